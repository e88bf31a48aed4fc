"""Axes run on their own, each at its rate."""
