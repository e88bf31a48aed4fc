"""position_plain.tally as machine code of the board. See there; the two give the same bits.

A word of three axes takes under a microsecond: the interrupt that makes words must not come too often while a segment
is counted. So each axis has a byte in which its steps are counted, for up to 255 words.
"""
# ruff: noqa: F821

import micropython


@micropython.viper
def tally(words: ptr32, mask: int, word: int, until: int, axes: int, position: ptr32) -> int:
    stepping = 0
    steps = (1 << axes) - 1
    while word != until:
        left = (until - word) & 0x1FFFFFFF
        if left > 255:
            left = 255
        forth = 0
        back = 0
        while left:
            levels = words[word & mask]
            made = levels & steps
            if made:
                stepping += 1
                ahead = made & (levels >> axes)
                forth += (ahead * 0x204081) & 0x1010101  # bit n to byte n
                back += ((made ^ ahead) * 0x204081) & 0x1010101
            word += 1
            left -= 1
        word &= 0x1FFFFFFF
        for axis in range(axes):
            position[axis] += ((forth >> (axis << 3)) & 255) - ((back >> (axis << 3)) & 255)
    return stepping
