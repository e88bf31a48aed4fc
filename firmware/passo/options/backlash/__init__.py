"""The lost motion of each axis is taken up."""
