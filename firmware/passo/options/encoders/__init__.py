"""Encoders count what the motors turn."""
