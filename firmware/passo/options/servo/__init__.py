"""A servo as pen lift."""
