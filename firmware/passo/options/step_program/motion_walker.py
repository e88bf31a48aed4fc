"""Walks a step program, forward or backward from any index, and turns it into words as it goes.

    walker = StepProgramWalker(program, lengths, tool_ticks=(0, 0))
    walker.go_to_start()
    walker.begin()                      # or begin(backward=True); begin(most=1) goes one unit
    planner.walk(walker, walker.tool)

A step is followed by its own period: its length along the path over the speed, in whole microseconds. 12½ ticks are a
microsecond; half a tick left over goes to the next step, so that the mean is exact. `set_speed` may be called at any
time: the interval under way lasts no longer than a new one would.

A walk ends at `most` units, at the program's end, at its start, or before a STATION, which only pass_station() passes. At the end of an
open program it goes on as soon as there is more. Its index is exact as the words made have it; the player knows how many have played.

A segment holds the intervals of steps in the same directions, in about two milliseconds, up to the next mark; or a piece of a wait. Marks
are passed between segments, so that within one the index advances by one a stepping word.
"""

from array import array

import micropython
from micropython import const

from passo.options.step_program.motion import DWELL, SPEED, STATION, TOOL, WAS
from passo.records import COUNT_MASK, ENDLESS, KIND_STEP_PROGRAM, TICKS_PER_MS

_SEGMENT_TICKS = const(25_000)
_PIECE_MS = const(2)  # longest word: the words ahead of the player stay short, and are never one alone
_PIECE = const(25_000)
_LONGEST_US = const(40_000_000)


class StepProgramWalker:
    """A geometry that makes whole words."""

    kind = KIND_STEP_PROGRAM

    def __init__(self, program, lengths, tool_ticks):
        """`lengths`: for each mask of axes how far a step goes, in nm × 60 and below 2³⁰; `tool_ticks`: the time of (off, on)."""
        self.program = program
        self.made = array("i", [0] * program.axes)  # signed steps since they were last cleared
        self.moving = self.negative = 0  # masks of the next run
        self.ticks = self.levels = 0  # of walk()'s words: their length, and the directions and tool at their end
        self.tool = self.backward = False
        self.left = 0  # 0: the walk has come to its end, once the gap is over
        self.gap = 0  # ticks until the next step may come
        self.wait_ms = 0  # of the wait under way
        self.index = self.cell = 0
        self.speed = 0  # mm/min
        self._done = 0  # units of the cell's item that lie behind, seen forward
        self._togo = ENDLESS
        self._dry = False  # an open program has nothing more just now
        self._wanted = 0  # a speed that takes effect with the next segment
        self._lengths = lengths
        self._each = array("i", [0] * len(lengths))  # half ticks a step
        self._half = 0  # half a tick carried on
        self._tool_ticks = tool_ticks

    # --- while no interrupt walks it

    def go_to_start(self):
        """Go to the start of the program, the tool off."""
        program = self.program
        self.cell = program.first
        self.index = program.start
        self._done = self._togo = self.left = self.wait_ms = self._wanted = 0
        self.tool = self._dry = False
        self._take_speed(program.speed_before)

    def pause_for(self, ticks):
        """Let the next step come after `ticks`."""
        self.gap = ticks

    def follow_walker(self, other):
        """Go on behind another walker, whose last interval may still run."""
        self.gap = max(self.gap, other.gap)
        other.gap = 0

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
            self._go_to_next()

    def pass_station(self):
        """Go past the STATION that the walk has come to. Returns its value; None if there is none."""
        program = self.program
        if self.cell == program.end or self._done:
            return None
        item = program.items[self.cell & program.mask]
        if item & 255 != STATION << 4:
            return None
        self._done = 1
        self.index = (self.index + 1) & COUNT_MASK
        return item >> 8

    def cut_program(self):
        """Let the program end here."""
        self.program.cut_off(self.cell, self._done, self.index)

    def at_start(self):
        """Return True if nothing lies behind."""
        return self.cell == self.program.first and not self._done

    def at_end(self):
        """Return True if nothing lies ahead."""
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
        """Return the period of a step of the axes in `mask` at the speed in force, in whole microseconds."""
        return self._period_us(mask, self._wanted or self.speed)

    # --- the next segment: may run in an interrupt, no integer of 2³⁰

    @micropython.native
    def ends(self):  # ISR: no allocation
        """Return True if no word of this walk is to come."""
        return not (self.left or self.gap)

    def rolling(self):  # ISR: no allocation
        """Return False: steps are slow enough to stop between two."""
        return False

    @micropython.native
    def ready(self):  # ISR: no allocation
        """Return True unless the walk has to wait for more items."""
        if self._dry:
            self._go_to_next()
        return not self._dry or self.gap > 0

    @micropython.native
    def walk(self, words, at, room, base, bits, hold=False):  # ISR: no allocation
        """Write at most `room` words to words[at:], about two milliseconds. Returns how many; 0 at the end of the walk."""
        if self._wanted:
            self._change_speed()
        self.levels = base
        self.ticks = 0
        if self.gap:
            gap = self.gap
            if gap > _PIECE:
                gap = _PIECE if gap >= 2 * _PIECE else gap >> 1
            self.gap -= gap
            if not self.gap and not self.wait_ms:
                self._go_to_next()
            return self._write_pause(words, at, gap, base, bits)
        if self.wait_ms:
            part = self.wait_ms if self.wait_ms < _PIECE_MS else _PIECE_MS
            self.wait_ms -= part
            if not self.wait_ms:
                self._step_over()
                self._go_to_next()
            return self._write_pause(words, at, part * TICKS_PER_MS, base, bits)
        if not self.left or self._dry:
            return 0
        return self._write_steps(words, at, room, base, bits)

    @micropython.native
    def _write_pause(self, words, at, ticks, base, bits):  # ISR: no allocation
        """Write a word of `ticks` without a step. Returns 1."""
        words[at] = ticks << bits | base
        self.ticks = ticks
        return 1

    @micropython.native
    def _write_steps(self, words, at, room, base, bits):  # ISR: no allocation
        """Write the words of as many steps as fit into `room` and a segment. Returns how many. Long, because runs may be short: each call would cost
        a run of one step 15 µs, so all is kept in locals, and _go_to_next() is left for the end."""
        program = self.program
        items = program.items
        cells = program.mask
        axes = program.axes
        made = self.made
        backward = self.backward
        directions = base >> axes
        moving = self.moving
        negative = self.negative
        cell = self.cell
        done = self._done
        index = self.index
        togo = self._togo
        half = self._half
        count = ticks = 0
        while True:
            left = done if backward else (items[cell & cells] >> 8) - done
            each = self._each[moving]
            steps = 1
            if each <= 2 * _PIECE:
                steps = 2 * (_SEGMENT_TICKS - ticks) // each + 1
                if steps > left:
                    steps = left
                if steps > room - count:
                    steps = room - count
                if togo >= 0 and steps > togo:
                    steps = togo
                levels = base | moving
                for i in range(at + count, at + count + steps):
                    half += each
                    words[i] = half >> 1 << bits | levels
                    ticks += half >> 1
                    half &= 1
            else:
                half += each
                self.gap = (half >> 1) - (_PIECE >> 1)
                words[at + count] = _PIECE >> 1 << bits | base | moving
                ticks += _PIECE >> 1
                half &= 1
            count += steps
            for axis in range(axes):
                if moving >> axis & 1:
                    made[axis] += -steps if negative >> axis & 1 else steps
            if togo > 0:
                togo -= steps
            if backward:
                done -= steps
                index -= steps
            else:
                done += steps
                index += steps
            if steps < left or not togo or self.gap or ticks >= _SEGMENT_TICKS or count >= room:
                break
            if backward:
                if cell == program.first:
                    break
                following = (cell - 1) & COUNT_MASK
            else:
                following = (cell + 1) & COUNT_MASK
                if following == program.end:
                    break
            item = items[following & cells]
            mask = item & 15
            if backward:
                item ^= mask << 4
            if not mask or (directions ^ ~(item >> 4)) & mask:
                break
            cell = following
            done = item >> 8 if backward else 0
            moving = mask
            negative = item >> 4 & 15
        self.cell = cell
        self._done = done
        self.index = index & COUNT_MASK
        self._togo = togo
        self._half = half
        self.moving = moving
        self.negative = negative
        self.ticks = ticks
        if not togo or not (done if backward else (items[cell & cells] >> 8) - done):
            self._go_to_next()
        return count

    @micropython.native
    def _step_over(self):  # ISR: no allocation
        """Pass the mark that the walk stands before."""
        if self.backward:
            self._done = 0
            self.index = (self.index - 1) & COUNT_MASK
        else:
            self._done = 1
            self.index = (self.index + 1) & COUNT_MASK
        if self._togo > 0:
            self._togo -= 1

    @micropython.native
    def _go_to_next(self):  # ISR: no allocation
        """Go from the end of an item over all marks that take no time to the next run or wait, or to the end."""
        program = self.program
        items = program.items
        self._dry = False
        while not self.gap:
            if self.backward:
                if not self._done:
                    if self.cell == program.first:
                        self.left = 0
                        return
                    self.cell = (self.cell - 1) & COUNT_MASK
                    item = items[self.cell & program.mask]
                    self._done = item >> 8 if item & 15 else 1
            elif self.cell == program.end:
                self._dry = program.open
                if not self._dry:
                    self.left = 0
                return
            item = items[self.cell & program.mask]
            size = item >> 8 if item & 15 else 1
            if not self.backward and self._done >= size:
                if (self.cell + 1) & COUNT_MASK == program.end:  # stay in it: it may still grow
                    self._dry = program.open
                    if not self._dry:
                        self.left = 0
                    return
                self.cell = (self.cell + 1) & COUNT_MASK
                self._done = 0
                continue
            if item & 0xFF == WAS << 4:
                self._done = 0 if self.backward else 1
                if self.backward:
                    self._take_speed(item >> 8)
                continue
            if not self._togo:
                self.left = 0
                return
            if item & 15:
                self.moving = item & 15
                self.negative = item >> 4 & 15
                if self.backward:
                    self.negative ^= self.moving
                return
            if self._pass_mark(item >> 4 & 15, item >> 8):
                return

    @micropython.native
    def _pass_mark(self, kind, value):  # ISR: no allocation
        """Act on a mark, and pass it. Returns True if the walk stays before it for now."""
        if kind == TOOL:
            tool = (value >> 1 if self.backward else value) & 1
            if tool != self.tool:
                self.tool = tool
                self.gap = self._tool_ticks[tool]
        elif not self.backward:
            if kind == STATION:
                self.left = 0
                return True
            if kind == SPEED:
                self._take_speed(value)
            elif kind == DWELL and value:
                self.wait_ms = value
                return True
        self._step_over()
        return False

    @micropython.native
    def _change_speed(self):  # ISR: no allocation
        """Take the speed asked for; the interval under way lasts no longer than a new one."""
        self._take_speed(self._wanted)
        self._wanted = 0
        if self.moving and self.gap and not self.wait_ms:
            longest = self._each[self.moving] >> 1
            if self.gap > longest:
                self.gap = longest

    @micropython.native
    def _take_speed(self, mm_min):  # ISR: no allocation
        """Compute the half ticks a step of each mask of axes at mm_min."""
        self.speed = mm_min
        for mask in range(1, len(self._each)):
            self._each[mask] = self._period_us(mask, mm_min) * 25

    @micropython.native
    def _period_us(self, mask, mm_min):  # ISR: no allocation
        """Return the whole microseconds of a step of the axes in `mask` at mm_min, _LONGEST_US at most."""
        period_us = (self._lengths[mask] + (mm_min >> 1)) // mm_min
        return period_us if period_us < _LONGEST_US else _LONGEST_US
