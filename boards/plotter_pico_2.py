"""The plotter of 2014 on a Raspberry Pi Pico 2, or Pico 2 W: the pins of a Pico, code compiled for the faster chip."""

BOARD = {"like": "plotter_2014", "name": "plotter_pico_2", "chip": "rp2350"}
