"""Where a job is, kept in flash."""
