"""Inputs forbid steps in a direction, outputs or the tool."""
