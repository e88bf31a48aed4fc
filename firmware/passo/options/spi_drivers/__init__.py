"""TMC2130 and TMC5160 drivers, set up over SPI."""
