"""The machine's position, from the words played: the last checkpoint played, and the steps in the words since."""

from array import array

import micropython

from passo.arrays import zeros
from passo.records import *
from passo.steps.position_viper import find, look, see, tally


class Latch:
    """The moment when an input changes, kept by its pin's interrupt: the main loop looks later, perhaps steps later. An interrupt of the
    feeder may be in the way, up to 1 ms: of steps further apart than that the position is exact.

        edge = port.watch_limit("limit_x")     # None: its pin has no interrupt to spare
        edge.begin(feeder, player)              # from here on
        edge.seen                               # True once it has changed
        feeder.position_view(played, edge)      # where the motors stood then
    """

    def __init__(self):
        self.seen = True
        self.first = self.words_played = 0  # the mark played last, and the words

    def begin(self, feeder, player):
        """Wait for the input's next change, with this feeder and player."""
        self._state = feeder.state
        self._player = player
        self.seen = False

    @micropython.native
    def hold(self):  # ISR: no allocation
        """Remember the words played at the first change since begin(). For the input's interrupt."""
        if not self.seen:
            self.first = self._state[FEED_OLDEST]
            self.words_played = self._player.words_played()
            self.seen = True


class Position:
    """The main loop's questions to the feeder, which writes the arrays that are read here."""

    def __init__(self, ring, layout, planner, drive):
        """As of a Feeder."""
        self.ring = ring
        self.layout = layout
        self.planner = planner
        self.drive = drive
        axes = layout.axes
        self._found = array("i", [0] * axes)  # of the last call of position_view()
        self._stepping = 0
        self._stride = MARK_FIELDS + axes
        self.marks = zeros(MARKS * self._stride)
        self.state = array("i", [0] * (FEED_POSITION + axes))
        self._seen_of = self.state, self.marks, ring.words, planner.rows, planner.indices

    def position(self, played):
        """Return a new list of the steps of each axis since power-up when `played` words have appeared on the pins: exact. If an interrupt has gone
        on meanwhile it is the position a moment later."""
        return list(self.position_view(played))

    def position_view(self, played, edge=None):
        """Return what position() does, in an array that the next call overwrites. With `edge`, a Latch: the position at its moment, exact to the
        step; the present position if more than 60 segments have been made since, or all have been dropped."""
        if edge and (self.state[FEED_NEWEST] - edge.first) & COUNT_MASK < MARKS - 2:
            state = self.state[:]
            state[FEED_OLDEST] = edge.first
            word = self.marks[find(state, self.marks, edge.words_played, self._found) + MARK_WORD]
            if (edge.words_played - word) & COUNT_MASK < COUNT_HALF:
                self._count(word, edge.words_played)
                return self._found
        self._walk(played)
        return self._found

    def look(self, played, origin, position, seen):
        """Write the position, less `origin`, to the array `position`, in steps; and SEEN_… (block, speed) to `seen`."""
        state, marks, words, rows, indices = self._seen_of
        if self.drive is None:
            look(state, marks, words, rows, indices, played, origin, position, seen)
            return
        see(state, marks, words, rows, indices, played, self._walk(played), seen)
        found = self._found
        for axis in range(len(found)):
            position[axis] = found[axis] - origin[axis]

    # In small pieces: each finds its variables' slots on the stack, and nothing is allocated while words are counted. Else
    # that can take longer than the time between two interrupts, and then no answer would ever be right.

    def _walk(self, played):
        """Return the index in the marks of the last checkpoint played; `_stepping`: words since that step; `_found`: the position."""
        state = self.state
        while True:
            oldest = state[FEED_OLDEST]
            at = find(state, self.marks, played, self._found)
            if (played - self.marks[at + MARK_WORD]) & COUNT_MASK < COUNT_HALF:
                self._stepping = self._count(self.marks[at + MARK_WORD], played)
                if state[FEED_OLDEST] == oldest:
                    return at
            played = state[FEED_PLAYED]  # an interrupt has gone beyond it, and may have written over those words

    def _count(self, word, played):
        """Bring `_found` from the checkpoint at word `word` to `played`, both below the ring's head. Returns the words since the last step."""
        ring = self.ring
        if self.drive is None:
            return tally(ring.words, ring.mask, word, played, self.layout.axes, self._found)
        return self.drive.tally(ring.words, ring.mask, word, played, self._found)

    def spot(self, played):
        """Return (index(played), position_view(played)) of one moment."""
        index = self.index(played)
        if index is None:
            self._walk(played)
        return index, self._found

    def index(self, played):
        """Return the index in the step program under way when `played` words have appeared on the pins; None if there is none."""
        planner = self.planner
        row = planner.row()
        if row < 0 or planner.rows[row + ROW_KIND] != KIND_STEP_PROGRAM:
            return None
        backward, index = planner.walker(row).backward, planner.rows[row + ROW_FIRST]
        at = self._walk(played)
        if not self.marks[at + MARK_ENDS]:
            index = self.marks[at + MARK_INDEX]
        elif at != self.state[FEED_OLDEST] % MARKS * self._stride:
            return self.marks[at + MARK_INDEX]  # played to its end, and not retired yet
        return (index - self._stepping if backward else index + self._stepping) & COUNT_MASK
