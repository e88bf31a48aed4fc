"""Walks a step program, forward or backward from any index, and turns it into words as it goes.

    walker = StepProgramWalker(program, lengths, tool_ticks=(0, 0))
    walker.rewind()
    walker.begin()                      # or begin(backward=True); begin(most=1) goes one unit
    planner.walk(walker, walker.tool)

A step is followed by its own period: its length along the path over the speed, in whole microseconds. 12½ ticks are a
microsecond; half a tick left over goes to the next step, so that the mean is exact. `set_speed` may be called at any
time: the interval under way lasts no longer than a new one would.

A walk ends at `most` units, at the program's end, at its start, or before a STATION, which only pass_station() passes.
At the end of an open program it goes on as soon as there is more. Its index is exact as the words made have it; whoever
plays them knows how many have played.
"""

from passo.motion.step_program import STATION
from passo.motion.step_program_words import StepProgramWords
from passo.records import COUNT_HALF, COUNT_MASK, ENDLESS, KIND_STEP_PROGRAM


class StepProgramWalker(StepProgramWords):
    """What the main loop does with it."""

    kind = KIND_STEP_PROGRAM

    # --- while no interrupt walks it

    def rewind(self):
        """Stand at the start of the program, the tool off."""
        program = self.program
        self.cell = program.first
        self.index = program.start
        self._done = self._togo = self.left = 0
        self.wait_ms = 0
        self.tool = False
        self._dry = False
        self._wanted = 0
        self._take_speed(program.speed_before)

    def pause(self, ticks):
        """The next step comes after `ticks`."""
        self.gap = ticks

    def follow(self, other):
        """Go on from another walker, whose last interval may still run."""
        self.pause(max(self.gap, other.gap))
        other.pause(0)

    def begin(self, backward=False, most=ENDLESS, lit=None):
        """Set out from where it stands. `lit`: the tool as it is now; None: as it should be."""
        if backward:
            self.wait_ms = 0
        if self._wanted:
            self._change_speed()
        self.backward = backward
        self.left = 1
        self._togo = most
        if lit is not None and lit != self.tool and self.gap < self._tool_ticks[self.tool]:
            self.gap = self._tool_ticks[self.tool]
        if not self.wait_ms:
            self._arrive()

    def pass_station(self):
        """Go past the STATION the walk has come to, and return its value; None if there is none."""
        program = self.program
        if self.cell == program.end or self._done:
            return None
        item = program.items[self.cell & program.mask]
        if item & 255 != STATION << 4:
            return None
        self._done = 1
        self.index = (self.index + 1) & COUNT_MASK
        return item >> 8

    def seek(self, index):
        """Stand at `index`, the tool and the speed as they are there; the next step comes a period later.

        Raises ValueError where the program has no such index."""
        self.gap = 0
        while self.index != index:
            ahead = (index - self.index) & COUNT_MASK
            backward = ahead >= COUNT_HALF
            self.begin(backward, COUNT_MASK + 1 - ahead if backward else ahead)
            if self.gap:
                self.gap = 0  # behind a change of the tool, which is passed
            elif self.wait_ms:
                self.wait_ms = 0
                self._step_over()
            elif self.left and not self._dry:
                self._advance(min(self._in_run(), self._togo))
            elif self.index != index and self.pass_station() is None:
                raise ValueError("no index %d in the program" % index)
        self.left = 0
        self.gap = self._each[self.moving] >> 1

    def cut(self):
        """Let the program end here."""
        self.program.cut(self.cell, self._done, self.index)

    def at_start(self):
        """True if there is nothing behind."""
        return self.cell == self.program.first and not self._done

    def at_end(self):
        """True if there is nothing ahead."""
        program = self.program
        if self.cell == program.end:
            return True
        item = program.items[self.cell & program.mask]
        return (self.cell + 1) & COUNT_MASK == program.end and self._done == (item >> 8 if item & 15 else 1)

    # --- at any time

    def set_speed(self, mm_min):
        """Go on at `mm_min` ≥ 1 along the path, up to the next SPEED."""
        self._wanted = mm_min

    def step_us(self, mask):
        """Period of a step of the axes in `mask` at the speed in force, whole microseconds."""
        return self._period_us(mask, self._wanted or self.speed)
