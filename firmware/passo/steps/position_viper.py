"""position.advance_plain as machine code of the board. See there; the two give the same bits."""
# ruff: noqa: F821

import micropython


@micropython.viper
def advance(position: ptr32, made: ptr32, marks: ptr32, at: int, axes: int):
    axis = 0
    while axis < axes:
        place = ((position[axis] + made[axis] + 0x10000000) & 0x1FFFFFFF) - 0x10000000
        position[axis] = place
        marks[at + axis] = place
        made[axis] = 0
        axis += 1
