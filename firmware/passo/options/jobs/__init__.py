"""Programs kept on the board, and run without a PC."""
