"""Makes files from the firmware's sources: a board's file system, package.json, the tables of docs/."""
