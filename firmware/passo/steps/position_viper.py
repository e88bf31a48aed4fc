"""The machine's position: the last checkpoint played, and the steps in words of the step form since.

    at = find(state, marks, played, position)
    stepping = tally(words, mask, word, until, axes, position)
    look(state, marks, words, rows, indices, played, origin, position, seen)  # all that a status report wants, of one moment

One text for all interpreters; see motion/block_viper.py.

A word of three axes takes under a microsecond: the interrupt that makes words must not come too often while a segment
is counted. So each axis has a byte in which its steps are counted, for up to 255 words.
"""
# Shared with interrupts: state, marks, indices

import micropython

from passo.motion.row_viper import room
from passo.motion.speed_viper import progress
from passo.records import *


@micropython.viper
def find(state: ptr32, marks: ptr32, played: int, position: ptr32) -> int:
    """Return the index in `marks` of the last one played; its position goes to `position`."""
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
        position[axis] = marks[at + MARK_FIELDS + axis]
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


@micropython.viper
def look(
    state: ptr32, marks: ptr32, words: ptr32, rows: ptr32, indices: ptr32, played: int, origin: ptr32, position: ptr32, seen: ptr32
):
    """Read the position when `played` words have appeared: less `origin` it goes to `position`, SEEN_… to `seen`. If an
    interrupt goes on meanwhile it is the position a moment later. Of words of the step form."""
    at = -1
    while at < 0:
        oldest = state[FEED_OLDEST]
        at = int(find(state, marks, played, position))
        word = marks[at + MARK_WORD]
        if ((played - word) & COUNT_MASK) < COUNT_HALF:
            tally(words, state[FEED_MASK], word, played, state[FEED_AXES], position)
            if state[FEED_OLDEST] != oldest:
                at = -1  # it has written over these words
        else:
            at = -1
        if at < 0:
            played = state[FEED_PLAYED]
    for axis in range(state[FEED_AXES]):
        position[axis] -= origin[axis]
    see(state, marks, words, rows, indices, played, at, seen)


@micropython.viper
def see(state: ptr32, marks: ptr32, words: ptr32, rows: ptr32, indices: ptr32, played: int, at: int, seen: ptr32):
    """All of SEEN_… when `played` words have appeared, and the last checkpoint played stands at `at` in `marks`."""
    axes = state[FEED_AXES]
    number = at // (MARK_FIELDS + axes)
    pace = 0
    if number != state[FEED_NEWEST] & (MARKS - 1):
        pace = marks[((number + 1) & (MARKS - 1)) * (MARK_FIELDS + axes) + MARK_PACE]
    retired = indices[QUEUE_RETIRED]
    seen[SEEN_ROOM] = int(room(indices))
    seen[SEEN_ROW] = -1 if retired == indices[QUEUE_FETCHED] else retired % QUEUE_SIZE * (ROW_STEPS + axes)
    seen[SEEN_PACE] = pace
    levels = words[(played - 1) & state[FEED_MASK]] & ((1 << state[FEED_BITS]) - 1)
    seen[SEEN_LIT] = 1 if levels & state[FEED_TOOL] else 0
    progress(rows, seen)
