"""Machines on an MQTT broker: what a PC beside them tells of them."""
