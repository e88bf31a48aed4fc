"""Following error: the encoders' counts against the player's steps.

    beyond = follow_steps(table, encoders, counts, position, after)      # mask of the encoders whose error is beyond its limit

`counts` were read between two looks at the player, when the axes stood at `position` and at `after`: an error counts as beyond only if it
is beyond for both. Each check adds what has changed since the one before, so nothing is rounded and nothing adds up; the counts between two
checks have to stay below 2²⁸. Takes about 3 µs an encoder on an RP2040, and allocates nothing.

One text for all interpreters; see motion/block_viper.py.
"""

import micropython
from micropython import const

from passo.records import COUNT_HALF, COUNT_MASK, MARK_WORD
from passo.steps.position_viper import find, tally

# A table: FOLLOW_FIELDS numbers an encoder. An error is in 1 / FOLLOW_NUM of a step, within ± 2²⁸.
FOLLOW_AXIS = const(0)
FOLLOW_NUM = const(1)  # FOLLOW_NUM counts are FOLLOW_DEN steps
FOLLOW_DEN = const(2)
FOLLOW_NEGATIVE = const(3)  # 1: it counts backwards
FOLLOW_LIMIT = const(4)  # the largest error
FOLLOW_COUNT = const(5)  # as last read, modulo 2²⁹
FOLLOW_PLACE = const(6)  # of the axis then
FOLLOW_OFF = const(7)  # 1: the axis's steps are not this motor's
FOLLOW_SHIFT = const(8)  # to be added to the error at the next check: the main loop writes it
FOLLOW_TOTAL = const(9)  # counts since the start
FOLLOW_ERROR = const(10)  # its turn, less its steps
FOLLOW_MOST = const(11)  # largest amount of it since the main loop cleared it
FOLLOW_FIELDS = const(12)


@micropython.viper
def to_signed(count: int) -> int:  # ISR: no allocation
    """Return a difference modulo 2²⁹ as the value nearest to 0."""
    count &= COUNT_MASK
    return count - COUNT_MASK - 1 if count >= COUNT_HALF else count


@micropython.viper
def follow_steps(table: ptr32, encoders: int, counts: ptr32, position: ptr32, after: ptr32) -> int:  # ISR: no allocation
    """Add what has changed since the last check to each encoder's error. Returns the mask of those whose error is beyond its limit. See above."""
    beyond = 0
    number = 0
    at = 0
    while number < encoders:
        count = int(to_signed(counts[number] - table[at + FOLLOW_COUNT]))
        if table[at + FOLLOW_NEGATIVE]:
            count = 0 - count
        table[at + FOLLOW_COUNT] = counts[number]
        table[at + FOLLOW_TOTAL] += count
        axis = table[at + FOLLOW_AXIS]
        steps = int(to_signed(position[axis] - table[at + FOLLOW_PLACE]))
        table[at + FOLLOW_PLACE] = position[axis]
        meanwhile = int(to_signed(after[axis] - position[axis]))
        if table[at + FOLLOW_OFF]:
            steps = 0
            meanwhile = 0
        error = table[at + FOLLOW_ERROR] + count * table[at + FOLLOW_DEN] - steps * table[at + FOLLOW_NUM]
        error = int(to_signed(error + table[at + FOLLOW_SHIFT]))
        table[at + FOLLOW_SHIFT] = 0
        table[at + FOLLOW_ERROR] = error
        least = error - meanwhile * table[at + FOLLOW_NUM]
        if error < 0:
            error = 0 - error
            least = 0 - least
        if least > error:
            least = error
        if least > table[at + FOLLOW_MOST]:
            table[at + FOLLOW_MOST] = least
        if least > table[at + FOLLOW_LIMIT]:
            beyond |= 1 << number
        number += 1
        at += FOLLOW_FIELDS
    return beyond


class Follower:
    """The axes' positions, for an interrupt: as Position.position(), in an array of the caller's."""

    def __init__(self, feeder):
        self._state = feeder.state
        self._marks = feeder.marks
        self._words = feeder.ring.words
        self._mask = feeder.ring.mask
        self._axes = feeder.layout.axes
        self._drive = feeder.drive

    @micropython.native
    def find_position(self, played, position):  # ISR: no allocation
        """Write the axes' positions to `position`, as `played` words have appeared on the pins."""
        word = self._marks[find(self._state, self._marks, played, position) + MARK_WORD]
        if (played - word) & COUNT_MASK < COUNT_HALF:
            self.add_steps(word, played, position)

    @micropython.native
    def add_steps(self, word, until, position):  # ISR: no allocation
        """Add to `position` what the words from count `word` to `until` step."""
        if self._drive is None:
            tally(self._words, self._mask, word, until, self._axes, position)
        else:
            self._drive.tally(self._words, self._mask, word, until, position)
