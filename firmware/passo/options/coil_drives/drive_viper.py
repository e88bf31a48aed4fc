"""From the step form to coil levels, and back to steps."""

import micropython


@micropython.viper
def apply(
    words: ptr32, at: int, count: int, axes: int, width: int, last: int, tables: ptr8, phases: ptr8
):  # ISR: no allocation
    """Turn words[at : at + count] from the step form into pin levels. `tables`: each axis's table of `last` + 1 phases,
    one after the other; `phases`: where each axis stands."""
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


@micropython.viper
def tally(
    words: ptr32, mask: int, word: int, until: int, axes: int, width: int, last: int, tables: ptr8, off: int,
    position: ptr32,
) -> int:
    """Add the steps that the words of a ring (its size − 1 is `mask`) from count `word` to `until` make to `position`,
    where the machine stands before them; returns how many of them step. A motor whose levels are `off` does not."""
    field = (1 << width) - 1
    stepping = 0
    while word != until:
        levels = words[word & mask]
        moved = 0
        axis = 0
        first = 0
        while axis < axes:
            phase = position[axis] & last
            now = levels & field
            if now != tables[first + phase] and now != off:
                moved = 1
                if now == tables[first + ((phase + 1) & last)]:
                    position[axis] += 1
                else:
                    position[axis] -= 1
            levels >>= width
            first += last + 1
            axis += 1
        stepping += moved
        word = (word + 1) & 0x1FFFFFFF
    return stepping
