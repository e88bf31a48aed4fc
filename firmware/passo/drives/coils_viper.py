"""coils.apply_plain as machine code of the board. See there; the two give the same bits."""
# ruff: noqa: F821

import micropython


@micropython.viper
def apply(words: ptr32, at: int, count: int, axes: int, width: int, last: int, tables: ptr8, phases: ptr8):
    keep = -1 << width * axes
    end = at + count
    while at < end:
        word = words[at]
        levels = 0
        axis = 0
        while axis < axes:
            phase = phases[axis]
            if (word >> axis) & 1:
                phase = (phase + ((word >> (axes + axis)) & 1) * 2 - 1) & last
                phases[axis] = phase
            levels |= tables[axis * (last + 1) + phase] << axis * width
            axis += 1
        words[at] = (word & keep) | levels
        at += 1
