"""Ramps with limited jerk: S-curves."""
