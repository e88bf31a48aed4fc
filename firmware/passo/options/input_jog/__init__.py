"""Inputs named `jog_…`: a jog pendant."""
