"""From the step form to the pins of a machine that has a gantry, and back to steps.

    step form      steps z y x            dirs z y x            `axes` bits each
    pins           steps x2 z y x         dirs x2 z y x         one more each
"""

import micropython


@micropython.viper
def double_steps(words: ptr32, at: int, count: int, axes: int, axis: int, motors: int):  # ISR: no allocation
    """Turn words[at : at + count] from the step form into pins: both motors of `axis` make its steps, or those of the mask
    `motors`: 1 the first, 2 the second."""
    field = (1 << axes) - 1
    keep = -1 << 2 * axes + 2
    end = at + count
    while at < end:
        word = words[at]
        steps = word & field
        dirs = (word >> axes) & field
        step = (steps >> axis) & 1
        if (motors & 1) == 0:
            steps = steps & ~(1 << axis)
        steps |= (step & (motors >> 1)) << axes
        dirs |= ((dirs >> axis) & 1) << axes
        words[at] = (word & keep) | (dirs << (axes + 1)) | steps
        at += 1


@micropython.viper
def tally(words: ptr32, mask: int, word: int, until: int, axes: int, axis: int, position: ptr32) -> int:
    """Add what the words of a ring (its size − 1 is `mask`) from count `word` to `until` step to `position`; returns how many
    of them step. A step of either motor is one of its axis."""
    field = (1 << axes) - 1
    stepping = 0
    while word != until:
        levels = words[word & mask]
        made = levels & field | ((levels >> axes) & 1) << axis
        if made:
            stepping += 1
            ahead = levels >> (axes + 1)
            number = 0
            while made:
                if made & 1:
                    position[number] += ((ahead & 1) << 1) - 1
                made >>= 1
                ahead >>= 1
                number += 1
        word = (word + 1) & 0x1FFFFFFF
    return stepping
