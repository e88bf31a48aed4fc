"""Machines on an MQTT broker: a PC beside them publishes their states, and a shop hands out jobs."""
