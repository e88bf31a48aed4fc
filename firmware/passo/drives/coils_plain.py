"""From the step form to coil levels, and back to steps."""


def apply(words, at, count, axes, width, last, tables, phases):  # ISR: no allocation
    """Turn words[at : at + count] from the step form into pin levels. `tables`: each axis's table of `last` + 1 phases,
    one after the other; `phases`: where each axis stands."""
    low = (1 << width * axes) - 1
    for i in range(at, at + count):
        word = words[i]
        levels = 0
        for axis in range(axes):
            phase = phases[axis]
            if word >> axis & 1:
                phase = phase + (1 if word >> (axes + axis) & 1 else -1) & last
                phases[axis] = phase
            levels |= tables[axis * (last + 1) + phase] << axis * width
        words[i] = (word & ~low) | levels


def tally(words, mask, word, until, axes, width, last, tables, off, position):
    """Add the steps that the words of a ring (its size − 1 is `mask`) from count `word` to `until` make to `position`,
    where the machine stands before them; returns how many of them step. A motor whose levels are `off` does not."""
    stepping = 0
    while word != until:
        levels = words[word & mask]
        moved = 0
        for axis in range(axes):
            phase = position[axis] & last
            now = levels >> axis * width & (1 << width) - 1
            first = axis * (last + 1)
            if now != tables[first + phase] and now != off:
                moved = 1
                position[axis] += 1 if now == tables[first + (phase + 1 & last)] else -1
        stepping += moved
        word = (word + 1) & 0x1FFFFFFF
    return stepping
