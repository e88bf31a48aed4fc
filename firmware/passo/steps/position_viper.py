"""position_plain.tally as machine code of the board. See there; the two give the same bits."""
# ruff: noqa: F821

import micropython


@micropython.viper
def tally(words: ptr32, mask: int, word: int, until: int, axes: int, position: ptr32) -> int:
    stepping = 0
    steps = (1 << axes) - 1
    while word != until:
        levels = words[word & mask]
        if levels & steps:
            stepping += 1
            axis = 0
            while axis < axes:
                if levels & 1:
                    if (levels >> axes) & 1:
                        position[axis] += 1
                    else:
                        position[axis] -= 1
                levels >>= 1
                axis += 1
        word = (word + 1) & 0x1FFFFFFF
    return stepping
