"""Runs on the board and on the PC: the bytes of the parallel port for a file's codes, as the firmware's status shows them.

    port_image("[A(Q)]", config)     # [0x80, 0x86, 0x81, 0xF1, 0x80, 0x00]; `config`: the section step_program of a board file
"""

from passo.protocols.pulses.codes import CODES
from passo.protocols.pulses.report import port_byte


def port_image(text, config):
    """Return the port's byte behind each code of `text`. `config`: step_program of a board file."""
    shown = []
    drives = tool = 0
    for letter in text:
        step = 0
        if letter in "[]":
            drives = letter == "["
        elif letter in "()":
            tool = letter == "("
        else:
            step = CODES[ord(letter) - 65]
        shown.append(port_byte(step, tool, drives, config))
    return shown
