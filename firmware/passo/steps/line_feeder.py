"""A feeder for machines that accelerate: lines that follow each other are made by one call of machine code a time.

Between two such calls what a line has come to stands in `state` alone (FEED_FAST is 1); its walker and block are told when
something else comes up: a hold, a wait, a block that is no accelerated line.
"""

import micropython

from passo.records import (
    FEED_DRY, FEED_FAST, FEED_HEAD, FEED_HOLD, FEED_LEAD, FEED_LEFT, FEED_PLAYED, FEED_ROW, LINE_FALL, LINE_MOVING,
    LINE_NEGATIVE, POWER_HEAD, POWER_TAIL,
)  # fmt: skip
from passo.steps.feeder import Feeder
from passo.steps.segments_viper import ENDED, FULL, STANDS, make


class LineFeeder(Feeder):
    def __init__(self, ring, layout, planner, drive, setup_ticks, min_word_ticks):
        Feeder.__init__(self, ring, layout, planner, drive, setup_ticks, min_word_ticks)
        self._arrays = (  # fetched at once; the bound method too, which would allocate
            self._marks, ring.words, planner.rows, planner.work, planner.counts, planner.line_state, ring.power.marks,
            self.settle,
        )  # fmt: skip

    @micropython.native
    def fill(self, played, lead_ticks):  # ISR: no allocation
        """As Feeder.fill()."""
        state = self.state
        if not state[FEED_FAST] or not self.open:
            return Feeder.fill(self, played, lead_ticks)
        what = FULL
        if not self.hold and not self.brake:
            what = self._lines(played, lead_ticks, False)
            if state[FEED_DRY]:
                self.late += 1
            if what == FULL:
                return True
        self._leave_lines(self._block, what)
        Feeder.fill(self, played, lead_ticks)
        return True

    @micropython.native
    def _lines(self, played, lead_ticks, held):  # ISR: no allocation
        """Accelerated lines, from the one under way on, as far as they go. See segments_viper.make() for the result."""
        marks, words, rows, work, counts, path, power, settle = self._arrays
        state = self.state
        state[FEED_PLAYED] = played
        state[FEED_LEAD] = lead_ticks
        state[FEED_HOLD] = 1 if held else 0
        state[FEED_DRY] = 0
        ramp = self.ramp
        what = make(state, marks, words, rows, work, counts, ramp.state, path, power, ramp.cut_short, settle)
        ring = self.ring
        ring.head = state[FEED_HEAD]
        if power[POWER_TAIL] != power[POWER_HEAD]:
            ring.power.play(played)
        return what

    def _accelerated(self, block, played, lead_ticks, held):  # ISR: no allocation
        """The block under way is an accelerated line: go on with it and those behind it. False if no more can be made now."""
        state = self.state
        state[FEED_ROW] = block.at
        state[FEED_LEFT] = block.walker.left
        state[FEED_FAST] = 1
        what = self._lines(played, lead_ticks, held)
        if what == FULL and not held:
            return False
        return self._leave_lines(block, what)

    def _leave_lines(self, block, what):  # ISR: no allocation
        """Something other than accelerated lines comes next. False if no more can be made now."""
        state = self.state
        state[FEED_FAST] = 0
        path = block.walker.state
        walker = block.walker
        walker.left = state[FEED_LEFT]
        walker.total = path[LINE_FALL] >> 1
        walker.moving = path[LINE_MOVING]
        walker.negative = path[LINE_NEGATIVE]
        block.at = state[FEED_ROW]
        if what == ENDED:
            self._block = None
        return what > STANDS
