"""A record of the time before an alarm or a crash."""
