"""A kernel of error diffusion: by how much a dot is too dark or too light is shared among those that follow. engraving.py makes the arrays.

Darkness is in parts of ONE: a share of an error is exact to some 2^-20 of a dot. No number reaches 2^31, for errors stay within a few dots.
"""

import micropython
from micropython import const

ONE = const(1 << 24)  # a whole dot's darkness
SHARE = const(3)  # numbers of a share: how far along the row, how many rows below, parts


@micropython.viper
def diffuse_row(dark: ptr32, errors: ptr32, shares: ptr32, parts: int, room: int, width: int, backward: int):
    """Make dots, 1 or 0, of the darkness of one row. `errors` has this row and those below it, each `room` longer than `dark` at both ends.
    `shares`: each how far along the row, how many rows below, how many of `parts`; behind the last are parts of 0."""
    pitch = width + 2 * room
    x = 0
    step = 1
    if backward:
        x = width - 1
        step = -1
    for _count in range(width):
        error = dark[x] + errors[room + x]
        dark[x] = 0
        if error >= ONE >> 1:
            dark[x] = 1
            error -= ONE
        error //= parts
        index = 0
        while shares[index + 2]:
            there = shares[index + 1] * pitch + room + x + step * shares[index]
            errors[there] += error * shares[index + 2]
            index += SHARE
        x += step
