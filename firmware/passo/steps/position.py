"""Where the machine is, from the words played: the last checkpoint played, and the steps in the words since."""

from micropython import const

from passo.motion.block import TRACK
from passo.steps.checkpoints import (
    ENDS, FIELDS, MARK_INDEX, MARK_PACE, MARKS, NEWEST, OLDEST, PLAYED, WORD, find,
)  # fmt: skip
from passo.steps.word import COUNT_MASK, ahead

_HALF = const(0x10000000)
_COUNT = const(0x1FFFFFFF)


def tally_plain(words, mask, word, until, axes, position):
    """Add what the words of a ring (its size − 1 is `mask`) from count `word` to `until` step, in the step form, to
    `position`; returns how many of them step."""
    stepping = 0
    steps = (1 << axes) - 1
    while word != until:
        levels = words[word & mask]
        if levels & steps:
            stepping += 1
            for axis in range(axes):
                if levels >> axis & 1:
                    position[axis] += 1 if levels >> axes + axis & 1 else -1
        word = (word + 1) & _COUNT
    return stepping


try:
    from passo.steps.position_viper import tally
except (ImportError, NameError, ValueError):  # an interpreter that has no machine code of its own
    tally = tally_plain


class Position:
    """What the main loop may ask of the feeder."""

    def position(self, played):
        """Steps of each axis since power-up when `played` words have appeared on the pins: exact. Where an interrupt
        has gone on meanwhile it is the position a moment later."""
        return self._walk(played)[0]

    def pace(self, played):
        """The mean speed of the segment under way, as ramp.pace; 0 where none is."""
        at = find(self.state, self._marks, played) // self._stride
        if at == self.state[NEWEST] % MARKS:
            return 0
        return self._marks[(at + 1) % MARKS * self._stride + MARK_PACE]

    def _walk(self, played):
        """(position, stepping words since the last checkpoint played, where in the marks that stands)."""
        ring = self.ring
        state = self.state
        axes = self.layout.axes
        while True:
            oldest = state[OLDEST]
            if ahead(played, self._marks[oldest % MARKS * self._stride + WORD]) >= _HALF:
                played = state[PLAYED]  # an interrupt has gone beyond it
            at = find(state, self._marks, played)
            position = self._marks[at + FIELDS : at + FIELDS + axes]
            word = self._marks[at + WORD]
            if self.drive is None:
                stepping = tally(ring.words, ring.mask, word, played, axes, position)
            else:
                stepping = self.drive.tally(ring.words, ring.mask, word, played, position)
            if state[OLDEST] == oldest:
                return list(position), stepping, at
            played = state[PLAYED]  # those words may have been written over: ask for what is now

    def _along(self, block, at, stepping):
        """How far `block` is, `stepping` words after the mark at `at`."""
        if block is None:
            return stepping
        start = block.first if self._marks[at + ENDS] else self._marks[at + MARK_INDEX]
        if block.kind == TRACK and block.walker.backward:
            stepping = -stepping
        return (start + stepping) & COUNT_MASK

    def place(self, played):
        """The place on the track under way when `played` words have appeared on the pins; None where there is none."""
        block = self.planner.playing()
        if block is None or block.kind != TRACK:
            return None
        _, stepping, at = self._walk(played)
        if self._marks[at + ENDS] and at != self.state[OLDEST] % MARKS * self._stride:
            return self._marks[at + MARK_INDEX]  # played to its end, and not retired yet
        return self._along(block, at, stepping)
