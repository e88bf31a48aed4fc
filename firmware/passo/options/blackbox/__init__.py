"""What leads to an alarm or a crash is kept."""
