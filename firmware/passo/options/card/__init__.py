"""A memory card keeps stored jobs."""
