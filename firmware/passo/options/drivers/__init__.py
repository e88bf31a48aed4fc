"""TMC2209 drivers, set up over a UART; homing by stall."""
