"""Makes files from the firmware's sources: a board's file system, the tables of docs/."""
