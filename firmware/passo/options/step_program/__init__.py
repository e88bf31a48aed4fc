"""A path written down step by step."""
