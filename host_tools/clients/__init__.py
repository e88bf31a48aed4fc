"""One client for each language of a board, and the serial port below them; and one wire for each, by which the page's machine speaks it."""
