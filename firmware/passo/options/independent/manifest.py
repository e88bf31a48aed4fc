"""Axes that run on their own: no key of a board file, languages ask for them."""

RULES = {}
