"""The feeder: turns the planner's blocks into step words, a segment at a time, and knows where the machine is.

    planner ─► block ─► walker (which axes) ─► pace (when) ─► drive (which pins) ─► ring

It fills by time, so that what it has committed to is never more than a few milliseconds ahead. At the end of each
segment it leaves a checkpoint: words, ticks and position so far (checkpoints.py). Position is the last checkpoint
played plus the words played since, never a walk over more than one segment. Words count as free only up to that
checkpoint.

`fill` and all it calls may run in an interrupt: they allocate nothing and every integer stays below 2³⁰. They are
compiled to machine code, because the interpreter's time a segment, not the steps, is what a board has least of. The
rest belongs to the main loop.
"""

from array import array

import micropython
from micropython import const

from passo.motion.block import INDEPENDENT, LINE, STEP_PROGRAM, WAIT
from passo.motion.line import MAX_RUN
from passo.motion.row_viper import begun
from passo.records import (
    COUNT_MASK, FEED_AXES, FEED_BITS, FEED_DEBT, FEED_DRIVE, FEED_FAST, FEED_HEAD, FEED_INDEX, FEED_LEAD, FEED_LEVELS,
    FEED_LIMIT, FEED_MASK, FEED_NEWEST, FEED_OLDEST, FEED_PACE, FEED_PLACE, FEED_POWER, FEED_SETUP, FEED_TICKS,
    FEED_TOOL, FEED_WAIT, HOLD_TICKS, MARKS, MARK_FIELDS, RAMP_PACE, RAMP_STEPS, RAMP_TICKS, ROW_DYNAMIC, ROW_POWER,
    ROW_RAPID, ROW_TICKS, ROW_TOP,
)  # fmt: skip
from passo.steps import pace
from passo.steps.checkpoints import begin, end, retire, room
from passo.steps.pace import repay
from passo.steps.position import Position

_UNKNOWN = const(2000)  # no power: the next segment marks its own in any case
_ROOM = MAX_RUN + 2  # words the longest segment needs, with a change of direction before it


class Feeder(Position):
    def __init__(self, ring, layout, planner, drive, setup_ticks, min_word_ticks):
        """`drive` turns the step form into pin levels, or is None where the step form is what the pins want;
        `setup_ticks` pass between a change of direction and the next step (0 where there is no DIR pin)."""
        self.ring = ring
        self.layout = layout
        self.planner = planner
        self.drive = drive
        self.setup_ticks = setup_ticks
        self.min_word_ticks = min_word_ticks
        self.ramp = planner.ramp
        axes = layout.axes
        self._none = array("i", [0] * axes)  # no steps made
        self._found = array("i", self._none)  # for who asks where the machine is
        self._stepping = 0
        self._stride = MARK_FIELDS + axes
        self._marks = array("i", [0] * (MARKS * self._stride))
        state = self.state = array("i", [0] * (FEED_PLACE + axes))
        state[FEED_BITS] = layout.bits
        state[FEED_AXES] = axes
        state[FEED_MASK] = ring.mask
        state[FEED_LIMIT] = ring.size - _ROOM
        state[FEED_SETUP] = setup_ticks
        state[FEED_TOOL] = layout.tool_mask
        state[FEED_DRIVE] = 0 if drive is None else 1
        self.open = True  # the main loop closes it while the motors are not ready, or while it stops the machine
        self.hold = False  # set: come to a stand on the path; cleared: go on
        self.brake = False  # the same, set by the port for as long as the main loop does not run
        self.late = 0  # times the player ran dry inside a block
        if drive is not None:
            ring.words[ring.mask] = drive.levels()  # the pins before the first word
        self._reset(0)

    def _reset(self, played):
        self._block = None
        self.ramp.stall()
        self.stood = False
        state = self.state
        state[FEED_WAIT] = state[FEED_FAST] = 0
        state[FEED_POWER] = _UNKNOWN
        state[FEED_HEAD] = played
        state[FEED_DEBT] = state[FEED_TICKS] = state[FEED_OLDEST] = state[FEED_NEWEST] = state[FEED_INDEX] = state[FEED_PACE] = 0
        end(state, self._marks, self._none, 0, 0, 1)
        state[FEED_OLDEST] = state[FEED_NEWEST]

    # --- filling: may run in an interrupt

    @micropython.native
    def fill(self, played, lead_ticks):  # ISR: no allocation
        """Make words until `lead_ticks` are ahead of the word count `played`, or nothing is released, or no room. True where
        a block had been begun, so that the player ought not to have stood still meanwhile."""
        if not self.open:
            return False
        state = self.state
        marks = self._marks
        ended = retire(state, marks, played)
        if ended:
            self.planner.retire(ended)
        self.ring.power.play(played)
        held = self.hold or self.brake
        if held and self.standing():
            self.stood = True
            state[FEED_POWER] = _UNKNOWN
            return False
        amid = self._block is not None and not self.stood
        if amid and state[FEED_OLDEST] == state[FEED_NEWEST]:
            self.late += 1
        self.stood = False
        state[FEED_LEAD] = lead_ticks
        while room(state, marks, lead_ticks):
            if held and self.standing():
                break
            block = self._block
            if block is None:
                if not self._fetch():
                    break
                if held and self.standing():
                    break
                block = self._block
            kind = block.kind
            if state[FEED_WAIT]:
                more = self._stand(block)
            elif kind == LINE and self.ramp.short:
                more = self._accelerated(block, played, lead_ticks, held)
            elif kind == INDEPENDENT or kind == STEP_PROGRAM:
                more = self._words(block.walker, held)
            else:
                more = self._segment(block, block.walker, held)
            if not more:
                break
        return amid

    def standing(self):  # ISR: no allocation
        """True when a hold has come to its stand; the words already made may still be playing."""
        if not (self.hold or self.brake) or self.ramp.moving():
            return False
        block = self._block
        return block is None or block.kind != INDEPENDENT or not block.walker.rolling()

    def amid(self):  # ISR: no allocation
        """True while a block has been begun that has words to come."""
        return self._block is not None and not self.stood

    def retire(self, played):  # ISR: no allocation
        """Give back the room, and the blocks, of all segments that have been played to their end."""
        ended = retire(self.state, self._marks, played)
        if ended:
            self.planner.retire(ended)

    def _fetch(self):  # ISR: no allocation
        ramp = self.ramp
        block = self.planner.next(ramp.moving())
        if block is None:
            return False
        self._block = block
        rows = block.rows
        at = block.at
        self._open(rows, at)
        kind = block.kind
        if kind == WAIT:
            self.state[FEED_WAIT] = rows[at + ROW_TICKS]
            ramp.stall()
            self._mark_power(block, 0)
        elif kind == INDEPENDENT or kind == STEP_PROGRAM:
            ramp.stall()
            self._mark_power(block, -1)
        else:
            ramp.begin(block)
        return True

    def _open(self, rows, at):  # ISR: no allocation
        """The tool, and where the index begins, of the block whose row begins at rows[at]."""
        state = self.state
        if begun(rows, at, state, state[FEED_TOOL]) != state[FEED_POWER]:
            state[FEED_POWER] = _UNKNOWN

    def _accelerated(self, block, played, lead_ticks, held):  # ISR: no allocation
        """An accelerated line is under way. LineFeeder knows a faster way."""
        return self._segment(block, block.walker, held)

    @micropython.native
    def _segment(self, block, walker, held):  # ISR: no allocation
        """One segment of an arc, or of a line without acceleration."""
        ramp = self.ramp
        made = ramp.state
        rows = block.rows
        row = block.at
        percent = self.planner.percent[rows[row + ROW_RAPID]]
        if ramp.short:
            ramp.cut_short(rows, row, made, walker.state, walker.left, percent, held)
        else:
            ramp.cut(walker.left, percent, held)
        steps = made[RAMP_STEPS]
        if not steps:
            return False
        state = self.state
        ticks = made[RAMP_TICKS]
        waits = ticks > HOLD_TICKS and steps == 1
        if waits:
            state[FEED_WAIT] = ticks - HOLD_TICKS
            ticks = HOLD_TICKS
        if rows[row + ROW_DYNAMIC] or state[FEED_POWER] == _UNKNOWN:
            self._mark_power(block, made[RAMP_PACE])
        else:
            state[FEED_PACE] = made[RAMP_PACE]
        ring = self.ring
        words = ring.words
        at = begin(state, words, walker.moving, walker.negative, steps, ticks)
        run = steps
        while run:
            part = run if at + run <= ring.size else ring.size - at
            walker.walk(words, at, part)
            pace.pace(words, at, part, state)
            if state[FEED_DEBT] or self.drive is not None:
                self.settle(at, part)
            at = 0
            run -= part
        self.finish(steps, ticks, not (walker.left or waits), walker.made)
        return True

    @micropython.native
    def _words(self, geometry, held):  # ISR: no allocation
        """One segment of a geometry that makes whole words: independent axes, a step program."""
        if not geometry.ready():
            self.stood = True  # there is no more yet: no word comes late
            return False
        state = self.state
        ring = self.ring
        if geometry.tool >= 0:
            levels = state[FEED_LEVELS] & ~state[FEED_TOOL]
            state[FEED_LEVELS] = levels | (state[FEED_TOOL] if geometry.tool else 0)
        at = begin(state, ring.words, geometry.moving, geometry.negative, 0, 0)
        room = ring.size - at
        if room > MAX_RUN:
            room = MAX_RUN
        count = geometry.walk(ring.words, at, room, state[FEED_LEVELS], state[FEED_BITS], held)
        ends = geometry.ends()
        if not count and not ends:
            return False
        state[FEED_LEVELS] = geometry.levels
        state[FEED_INDEX] = geometry.place
        self.settle(at, count)
        self.finish(count, geometry.ticks, ends, geometry.made)
        return True

    def _stand(self, block):  # ISR: no allocation
        state = self.state
        ticks = state[FEED_WAIT]
        if ticks > HOLD_TICKS:
            ticks = HOLD_TICKS
        state[FEED_WAIT] -= ticks
        ring = self.ring
        at = state[FEED_HEAD] & ring.mask
        ring.words[at] = ticks << state[FEED_BITS] | state[FEED_LEVELS]
        self.settle(at, 1)
        self.finish(1, ticks, not state[FEED_WAIT] and (block.kind == WAIT or block.walker.left == 0), self._none)
        return True

    def _mark_power(self, block, pace):  # ISR: no allocation
        """The segment that follows has this mean speed: mark the power where it changes."""
        self.state[FEED_PACE] = pace
        rows = block.rows
        at = block.at
        power = rows[at + ROW_POWER]
        if rows[at + ROW_DYNAMIC] and pace >= 0:
            power = power * pace // rows[at + ROW_TOP] if pace else 0
        if power != self.state[FEED_POWER]:
            self.state[FEED_POWER] = power
            self.ring.power.put(self.ring.head, power)

    @micropython.native
    def settle(self, at, count):  # ISR: no allocation
        """Take what is owed off words[at : at + count] and give them their drive's levels."""
        words = self.ring.words
        state = self.state
        owed = state[FEED_DEBT]
        if owed:
            debt = repay(words, at, count, state[FEED_BITS], owed, self.min_word_ticks)
            state[FEED_TICKS] = (state[FEED_TICKS] - owed + debt) & COUNT_MASK
            state[FEED_DEBT] = debt
        if self.drive is not None:
            self.drive.apply(words, at, count)

    @micropython.native
    def finish(self, count, ticks, ends, made):  # ISR: no allocation
        """Publish a segment of `count` words, with a checkpoint behind it."""
        state = self.state
        self.ring.head = end(state, self._marks, made, count, ticks, 1 if ends else 0)
        if ends:
            self._block = None

    # --- stopping: main loop only; asking is in position.py

    def cancel(self, played):
        """After the player has halted, and with `open` cleared: drop all words not played, take their place as truth.

        Returns (position, block, index): the block that was under way, if any, and how many of its dominant steps
        have been made (of a track: the place), so that it can be taken up again. The planner keeps its blocks.
        """
        self.retire(played)
        at = self._walk(played)
        position = list(self._found)
        block = self.planner.playing()
        index = self._along(block, at, self._stepping)
        self.ring.head = played
        self.ring.power.clear()
        for axis in range(self.layout.axes):
            self.state[FEED_PLACE + axis] = position[axis]
        if self.drive is not None:
            self.drive.seek(position)
        self.state[FEED_LEVELS] &= ~self.layout.tool_mask
        self._reset(played)
        return position, block, index
