"""The position in a job, kept in flash."""
