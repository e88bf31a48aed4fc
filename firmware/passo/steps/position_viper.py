"""Where the machine is: the last checkpoint played, and the steps in words of the step form since.

    at = find(state, marks, played, place)
    stepping = tally(words, mask, word, until, axes, position)

One text for all interpreters: a board compiles it to machine code, elsewhere it is ordinary Python.

A word of three axes takes under a microsecond: the interrupt that makes words must not come too often while a segment
is counted. So each axis has a byte in which its steps are counted, for up to 255 words.
"""
# Shared with interrupts: state, marks
# ruff: noqa: F821

import micropython

from passo.records import COUNT_HALF, COUNT_MASK, FEED_AXES, FEED_NEWEST, FEED_OLDEST, MARKS, MARK_FIELDS, MARK_WORD

try:
    ptr32
except NameError:
    ptr32 = None  # a name that only viper's compiler knows


@micropython.viper
def find(state: ptr32, marks: ptr32, played: int, place: ptr32) -> int:
    """Where in `marks` the last one played stands; its position goes to `place`."""
    number = state[FEED_OLDEST]
    stride = MARK_FIELDS + state[FEED_AXES]
    while number != state[FEED_NEWEST]:
        after = (number + 1) & COUNT_MASK
        if ((played - marks[(after & (MARKS - 1)) * stride + MARK_WORD]) & COUNT_MASK) >= COUNT_HALF:
            break
        number = after
    at = (number & (MARKS - 1)) * stride
    axis = stride - MARK_FIELDS
    while axis:
        axis -= 1
        place[axis] = marks[at + MARK_FIELDS + axis]
    return at


@micropython.viper
def tally(words: ptr32, mask: int, word: int, until: int, axes: int, position: ptr32) -> int:
    """Add what the words of a ring (its size − 1 is `mask`) from count `word` to `until` step, in the step form, to
    `position`; returns how many of them step."""
    stepping = 0
    steps = (1 << axes) - 1
    while word != until:
        left = (until - word) & COUNT_MASK
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
        word &= COUNT_MASK
        for axis in range(axes):
            position[axis] += ((forth >> (axis << 3)) & 255) - ((back >> (axis << 3)) & 255)
    return stepping
