"""Inputs and outputs behind shift registers on four pins."""
