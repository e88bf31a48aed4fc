"""A page before a board on a cable: what it may ask, in which words the board is told, and what it is shown."""
