"""The plotter of 2014 on a Raspberry Pi Pico W: the Pico's pins and the same files. GP23, GP24, GP25 and GP29 are taken by
its radio, so a machine file for a Pico that uses none of them serves a Pico W too.
"""

BOARD = {"like": "plotter_2014", "name": "plotter_pico_w"}
