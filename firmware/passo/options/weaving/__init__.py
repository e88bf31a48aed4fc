"""Seams made of lines and arcs."""
