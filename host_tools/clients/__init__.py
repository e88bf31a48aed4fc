"""One client for each language of a board, and the serial port below them."""
