"""Motors that are not the axes."""
