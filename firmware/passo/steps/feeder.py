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

from passo.motion.block import FREE, TRACK, WAIT
from passo.motion.line import MAX_RUN
from passo.motion.ramp import Ramp
from passo.steps import pace
from passo.steps.checkpoints import begin, end, retire, room
from passo.steps.pace import repay
from passo.steps.position import Position
from passo.steps.word import HOLD_TICKS

_COUNT = const(0x1FFFFFFF)  # COUNT_MASK, known to the compiler
# In the arrays, as checkpoints_plain.py has them.
_BITS = const(5)
_AXES = const(6)
_MASK = const(7)
_LIMIT = const(8)
_SETUP = const(9)
_LEVELS = const(10)
_DEBT = const(11)
_TICKS = const(12)
_HEAD = const(13)
_OLDEST = const(14)
_NEWEST = const(15)
_INDEX = const(16)
_PACE = const(17)
_PLACE = const(19)
_MARKS = const(128)
_FIELDS = const(5)
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
        self._ramp = Ramp()
        axes = layout.axes
        self._none = array("i", [0] * axes)  # no steps made
        self._found = array("i", self._none)  # for who asks where the machine is
        self._stride = _FIELDS + axes
        self._marks = array("i", [0] * (_MARKS * self._stride))
        state = self.state = array("i", [0] * (_PLACE + axes))
        state[_BITS] = layout.bits
        state[_AXES] = axes
        state[_MASK] = ring.mask
        state[_LIMIT] = ring.size - _ROOM
        state[_SETUP] = setup_ticks
        self.open = True  # the main loop closes it while the motors are not ready, or while it stops the machine
        self.hold = False  # set: come to a stand on the path; cleared: go on
        self.brake = False  # the same, set by the port for as long as the main loop does not run
        self.late = 0  # times the player ran dry inside a block
        self._power = -1  # of the last mark put; -1: the next segment puts one in any case
        if drive is not None:
            ring.words[ring.mask] = drive.levels()  # the pins before the first word
        self._reset(0)

    def _reset(self, played):
        self._block = None
        self._ramp.stall()
        self._stood = False
        self._power = -1
        self._wait = 0
        state = self.state
        state[_HEAD] = played
        state[_DEBT] = state[_TICKS] = state[_OLDEST] = state[_NEWEST] = state[_INDEX] = state[_PACE] = 0
        end(state, self._marks, self._none, 0, 0, 1)
        state[_OLDEST] = state[_NEWEST]

    # --- filling: may run in an interrupt

    @micropython.native
    def fill(self, played, lead_ticks):  # ISR: no allocation
        """Make words until `lead_ticks` are ahead of the word count `played`, or nothing is released, or no room. True where
        a block had been begun, so that the player ought not to have stood still meanwhile."""
        if not self.open:
            return False
        self.retire(played)
        self.ring.power.play(played)
        if (self.hold or self.brake) and self.standing():
            self._stood = True
            self._power = -1
            return False
        state = self.state
        amid = self._block is not None and not self._stood
        if amid and state[_OLDEST] == state[_NEWEST]:
            self.late += 1
        self._stood = False
        marks = self._marks
        while room(state, marks, lead_ticks) and self._segment(lead_ticks):
            pass
        return amid

    @micropython.native
    def standing(self):  # ISR: no allocation
        """True when a hold has come to its stand; the words already made may still be playing."""
        if not (self.hold or self.brake) or self._ramp.moving():
            return False
        block = self._block
        return block is None or block.kind != FREE or not block.walker.rolling()

    def amid(self):  # ISR: no allocation
        """True while a block has been begun that has words to come."""
        return self._block is not None and not self._stood

    @micropython.native
    def retire(self, played):  # ISR: no allocation
        """Give back the room, and the blocks, of all segments that have been played to their end."""
        ended = retire(self.state, self._marks, played)
        while ended:
            self.planner.retire()
            ended -= 1

    @micropython.native
    def _segment(self, lead_ticks):  # ISR: no allocation
        """Make a segment, or several of one line. False where there is none to make now."""
        held = self.hold or self.brake
        if held and self.standing():
            return False
        if self._block is None:
            if not self._fetch():
                return False
            if held and self.standing():
                return False
        block = self._block
        if self._wait:
            return self._stand(block)
        kind = block.kind
        if kind == FREE:
            return self._free(block.walker, held)
        if kind == TRACK:
            return self._track(block.walker)
        return self._line(block, block.walker, held, lead_ticks)

    @micropython.native
    def _fetch(self):  # ISR: no allocation
        block = self.planner.next(self._ramp.moving())
        if block is None:
            return False
        self._block = block
        state = self.state
        state[_INDEX] = block.first
        tool = self.layout.tool_mask
        state[_LEVELS] = state[_LEVELS] & ~tool | (tool if block.tool else 0)
        self._power = -1
        kind = block.kind
        if kind == WAIT:
            self._wait = block.ticks
            self._ramp.stall()
            self._mark_power(block, 0)
        elif kind == FREE or kind == TRACK:
            self._ramp.stall()
            self._mark_power(block, -1)
        else:
            self._ramp.begin(block)
        return True

    @micropython.native
    def _line(self, block, walker, held, lead_ticks):  # ISR: no allocation
        ramp = self._ramp
        ring = self.ring
        words = ring.words
        size = ring.size
        state = self.state
        marks = self._marks
        dynamic = block.dynamic
        drive = self.drive
        percent = self.planner.percent[block.rapid]
        while True:
            ramp.cut(walker.left, percent, held)
            steps = ramp.steps
            if not steps:
                return False
            ticks = ramp.ticks
            waits = ticks > HOLD_TICKS and steps == 1
            if waits:
                self._wait = ticks - HOLD_TICKS
                ticks = HOLD_TICKS
            if dynamic or self._power < 0:
                self._mark_power(block, ramp.pace)
            else:
                state[_PACE] = ramp.pace
            at = begin(state, words, walker.moving, walker.negative, steps, ticks)
            run = steps
            if at + steps > size:
                run = size - at
                walker.walk(words, at, run)
                pace.pace(words, at, run, state)
                self._settle(at, run)
                at = 0
                run = steps - run
            walker.walk(words, at, run)
            pace.pace(words, at, run, state)
            if state[_DEBT] or drive is not None:
                self._settle(at, run)
            if walker.left == 0 and not waits:
                ring.head = end(state, marks, walker.made, steps, ticks, 1)
                self._block = None
                return True
            ring.head = end(state, marks, walker.made, steps, ticks, 0)
            if waits or not room(state, marks, lead_ticks):
                return True

    @micropython.native
    def _free(self, walker, held):  # ISR: no allocation
        ring = self.ring
        state = self.state
        at = state[_HEAD] & ring.mask
        most = ring.size - at
        count = walker.walk(ring.words, at, MAX_RUN if most > MAX_RUN else most, state[_LEVELS], state[_BITS], held)
        ends = walker.ends()
        if not count and not ends:
            return False
        state[_LEVELS] = walker.levels
        self._settle(at, count)
        self._end(count, walker.ticks, ends, walker.made)
        return True

    @micropython.native
    def _track(self, walker):  # ISR: no allocation
        if not walker.ready():
            self._stood = True  # there is no more yet: no word comes late
            return False
        ring = self.ring
        state = self.state
        tool = self.layout.tool_mask
        levels = state[_LEVELS] & ~tool | (tool if walker.tool else 0)
        state[_LEVELS] = levels
        at = begin(state, ring.words, walker.moving, walker.negative, 0, 0)
        most = ring.size - at
        count = walker.walk(ring.words, at, MAX_RUN if most > MAX_RUN else most, state[_LEVELS], state[_BITS])
        self._settle(at, count)
        state[_INDEX] = walker.place
        self._end(count, walker.ticks, not walker.active(), walker.made)
        return True

    @micropython.native
    def _stand(self, block):  # ISR: no allocation
        ticks = self._wait
        if ticks > HOLD_TICKS:
            ticks = HOLD_TICKS
        self._wait -= ticks
        ring = self.ring
        state = self.state
        at = state[_HEAD] & ring.mask
        ring.words[at] = ticks << state[_BITS] | state[_LEVELS]
        self._settle(at, 1)
        self._end(1, ticks, not self._wait and (block.kind == WAIT or block.walker.left == 0), self._none)
        return True

    @micropython.native
    def _mark_power(self, block, pace):  # ISR: no allocation
        """The segment that follows has this mean speed: mark the power where it changes."""
        self.state[_PACE] = pace
        power = block.power
        if block.dynamic and pace >= 0:
            power = power * pace // block.top if pace else 0
        if power != self._power:
            self._power = power
            self.ring.power.put(self.ring.head, power)

    @micropython.native
    def _settle(self, at, count):  # ISR: no allocation
        """Take what is owed off words[at : at + count] and give them their drive's levels."""
        words = self.ring.words
        state = self.state
        owed = state[_DEBT]
        if owed:
            debt = repay(words, at, count, state[_BITS], owed, self.min_word_ticks)
            state[_TICKS] = (state[_TICKS] - owed + debt) & _COUNT
            state[_DEBT] = debt
        if self.drive is not None:
            self.drive.apply(words, at, count)

    @micropython.native
    def _end(self, count, ticks, ends, made):  # ISR: no allocation
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
        stepping, at = self._walk(played)
        position = list(self._found)
        block = self.planner.playing()
        index = self._along(block, at, stepping)
        self.ring.head = played
        self.ring.power.clear()
        for axis in range(self.layout.axes):
            self.state[_PLACE + axis] = position[axis]
        if self.drive is not None:
            self.drive.seek(position)
        self.state[_LEVELS] &= ~self.layout.tool_mask
        self._reset(played)
        return position, block, index
