"""The feeder: turns the planner's blocks into step words, a segment at a time, and knows where the machine is.

    planner ─► block ─► walker (which axes) ─► pace (when) ─► drive (which pins) ─► ring

It fills by time, so that what it has committed to is never more than a few milliseconds ahead. At the end of each
segment it leaves a checkpoint: words, ticks and position so far. Position is the last checkpoint played plus the words
played since, never a walk over more than one segment. Words count as free only up to that checkpoint.

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
from passo.steps.pace import new_terms, repay, set_terms
from passo.steps.position import advance, tally
from passo.steps.word import COUNT_MASK, HOLD_TICKS, ahead

_CHECKPOINTS = const(256)
_HALF = const(0x10000000)
_COUNT = const(0x1FFFFFFF)  # COUNT_MASK, known to the compiler
# Words the longest segment needs, with a change of direction before it; and as many again and some, so that what the main
# loop reads back (`_walk`) still stands there when the interrupt has retired that segment meanwhile.
_ROOM = 2 * (MAX_RUN + 2) + 256


class Feeder:
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
        self._terms = new_terms()
        axes = layout.axes
        self._none = array("i", [0] * axes)  # no steps made
        self._position = array("i", [0] * axes)  # after the last word made, steps since power-up
        self._mark_word = array("i", [0] * _CHECKPOINTS)
        self._mark_ticks = array("i", [0] * _CHECKPOINTS)
        self._mark_index = array("i", [0] * _CHECKPOINTS)  # dominant steps of its block made so far; of a track, the place
        self._mark_ends = bytearray(_CHECKPOINTS)  # 1 where the segment is its block's last
        self._mark_pace = array("i", [0] * _CHECKPOINTS)  # as ramp.pace; 0 at a stand
        self._mark_position = array("i", [0] * (_CHECKPOINTS * axes))
        self.open = True  # the main loop closes it while the motors are not ready, or while it stops the machine
        self.hold = False  # set: come to a stand on the path; cleared: go on
        self.late = 0  # times the player ran dry inside a block
        self._power = -1  # of the last mark put; -1: the next segment puts one in any case
        self._pace = 0
        self._levels = 0  # step form of the levels now: directions and tool
        if drive is not None:
            ring.words[ring.mask] = drive.levels()  # the pins before the first word
        self._reset(0)

    def _reset(self, played):
        self._block = None
        self._ramp.stall()
        self._stood = False
        self._power = -1
        self._pace = 0
        self._index = 0
        self._wait = 0
        self._debt = 0
        self._ticks = 0
        self._oldest = 0  # the last checkpoint played: a mark number, for ever, modulo 2²⁹
        self._newest = 0
        self._leave_mark(played, True, self._none)
        self._oldest = self._newest

    # --- filling: may run in an interrupt

    @micropython.native
    def fill(self, played, lead_ticks):  # ISR: no allocation
        """Make words until `lead_ticks` are ahead of the word count `played`, or nothing is released, or no room."""
        if not self.open:
            return
        self.retire(played)
        self.ring.power.play(played)
        if self.standing():
            self._stood = True
            self._power = -1
            return
        if self._block is not None and self._oldest == self._newest and not self._stood:
            self.late += 1
        self._stood = False
        oldest = self._oldest % _CHECKPOINTS
        while (self._ticks - self._mark_ticks[oldest]) & _COUNT < lead_ticks:
            if not self._segment():
                return

    @micropython.native
    def standing(self):  # ISR: no allocation
        """True when a hold has come to its stand; the words already made may still be playing."""
        if not self.hold or self._ramp.moving():
            return False
        block = self._block
        return block is None or block.kind != FREE or not block.walker.rolling()

    @micropython.native
    def retire(self, played):  # ISR: no allocation
        """Give back the room, and the blocks, of all segments that have been played to their end."""
        while self._oldest != self._newest:
            number = (self._oldest + 1) & _COUNT
            slot = number % _CHECKPOINTS
            if (played - self._mark_word[slot]) & _COUNT >= _HALF:
                return
            self._oldest = number
            if self._mark_ends[slot]:
                self.planner.retire()

    @micropython.native
    def _segment(self):  # ISR: no allocation
        oldest = self._oldest
        if (self._newest - oldest) & _COUNT >= _CHECKPOINTS - 1:
            return False
        ring = self.ring
        if (ring.head - self._mark_word[oldest % _CHECKPOINTS]) & _COUNT > ring.size - _ROOM:
            return False
        if self.standing() or self._block is None and not self._fetch():
            return False
        if self.standing():
            return False
        block = self._block
        if self._wait:
            self._hold()
        elif block.kind == FREE:
            return self._free(block.walker)
        elif block.kind == TRACK:
            return self._track(block.walker)
        else:
            return self._line(block.walker)
        return True

    @micropython.native
    def _fetch(self):  # ISR: no allocation
        block = self.planner.next(self._ramp.moving())
        if block is None:
            return False
        self._block = block
        self._index = block.first
        tool = self.layout.tool_mask
        self._levels = self._levels & ~tool | (tool if block.tool else 0)
        self._power = -1
        if block.kind == WAIT:
            self._wait = block.ticks
            self._ramp.stall()
            self._mark_power(block, 0)
        elif block.kind == FREE or block.kind == TRACK:
            self._ramp.stall()
            self._mark_power(block, -1)
        else:
            self._ramp.begin(block)
        return True

    @micropython.native
    def _line(self, walker):  # ISR: no allocation
        ramp = self._ramp
        ramp.cut(walker.left, self.planner.percent[self._block.rapid], self.hold)
        steps = ramp.steps
        ticks = ramp.ticks
        if not steps:
            return False
        if ticks > HOLD_TICKS and steps == 1:
            self._wait = ticks - HOLD_TICKS
            ticks = HOLD_TICKS
        self._mark_power(self._block, ramp.pace)
        self._turn(walker)
        ring = self.ring
        set_terms(self._terms, steps, ticks, self._levels, self.layout.bits)
        made = 0
        while made < steps:
            at = (ring.head + made) & ring.mask
            run = min(steps - made, ring.size - at)
            walker.walk(ring.words, at, run)
            pace.pace(ring.words, at, run, self._terms)
            if self._debt or self.drive is not None:
                self._settle(at, run)
            made += run
        self._index += steps
        self._finish(steps, ticks, walker.left == 0 and not self._wait, walker.made)
        return True

    @micropython.native
    def _free(self, walker):  # ISR: no allocation
        ring = self.ring
        at = ring.head & ring.mask
        room = min(MAX_RUN, ring.size - at)
        count = walker.walk(ring.words, at, room, self._levels, self.layout.bits, self.hold)
        ends = walker.ends()
        if not count and not ends:
            return False
        self._levels = walker.levels
        self._settle(at, count)
        self._finish(count, walker.ticks, ends, walker.made)
        return True

    @micropython.native
    def _track(self, walker):  # ISR: no allocation
        if not walker.ready():
            self._stood = True  # there is no more yet: no word comes late
            return False
        tool = self.layout.tool_mask
        self._levels = self._levels & ~tool | (tool if walker.tool else 0)
        self._turn(walker)
        ring = self.ring
        at = ring.head & ring.mask
        count = walker.walk(ring.words, at, min(MAX_RUN, ring.size - at), self._levels, self.layout.bits)
        self._settle(at, count)
        self._index = walker.place
        self._finish(count, walker.ticks, not walker.active(), walker.made)
        return True

    @micropython.native
    def _hold(self):  # ISR: no allocation
        ticks = min(self._wait, HOLD_TICKS)
        self._wait -= ticks
        ring = self.ring
        at = ring.head & ring.mask
        ring.words[at] = ticks << self.layout.bits | self._levels
        self._settle(at, 1)
        block = self._block
        self._finish(1, ticks, not self._wait and (block.kind == WAIT or block.walker.left == 0), self._none)

    @micropython.native
    def _mark_power(self, block, pace):  # ISR: no allocation
        """The segment that follows has this mean speed: mark the power where it changes."""
        self._pace = pace
        power = block.power
        if block.dynamic and pace >= 0:
            power = power * pace // block.top if pace else 0
        if power != self._power:
            self._power = power
            self.ring.power.put(self.ring.head, power)

    @micropython.native
    def _turn(self, walker):  # ISR: no allocation
        """Set the directions that differ, as a stepless word of the set-up time, owed by the intervals that follow."""
        layout = self.layout
        moving = walker.moving
        levels = self._levels & ~(moving << layout.axes) | (moving & ~walker.negative) << layout.axes
        if levels == self._levels:
            return
        self._levels = levels
        if self.setup_ticks:
            ring = self.ring
            at = ring.head & ring.mask
            ring.words[at] = self.setup_ticks << layout.bits | levels
            ring.publish(1)
            self._debt += self.setup_ticks
            self._ticks = (self._ticks + self.setup_ticks) & COUNT_MASK

    @micropython.native
    def _settle(self, at, count):  # ISR: no allocation
        """Take what is owed off words[at : at + count] and give them their drive's levels."""
        words = self.ring.words
        if self._debt:
            debt = repay(words, at, count, self.layout.bits, self._debt, self.min_word_ticks)
            self._ticks = (self._ticks - self._debt + debt) & COUNT_MASK
            self._debt = debt
        if self.drive is not None:
            self.drive.apply(words, at, count)

    @micropython.native
    def _finish(self, count, ticks, ends, made):  # ISR: no allocation
        """Publish a segment of `count` words, with a checkpoint behind it."""
        ring = self.ring
        head = (ring.head + count) & _COUNT
        self._ticks = (self._ticks + ticks) & _COUNT
        self._leave_mark(head, ends, made)
        ring.head = head
        if ends:
            self._block = None

    @micropython.native
    def _leave_mark(self, word, ends, made):  # ISR: no allocation
        number = (self._newest + 1) & _COUNT
        slot = number % _CHECKPOINTS
        ring = self.ring
        layout = self.layout
        axes = layout.axes
        self._mark_word[slot] = word
        self._mark_ticks[slot] = self._ticks
        self._mark_index[slot] = self._index
        self._mark_ends[slot] = ends
        self._mark_pace[slot] = self._pace
        advance(self._position, made, self._mark_position, slot * axes, axes)
        self._newest = number

    # --- asking and stopping: main loop only

    def position(self, played):
        """Steps of each axis since power-up when `played` words have appeared on the pins: exact."""
        return self._walk(played)[0]

    def pace(self, played):
        """The mean speed of the segment under way, as ramp.pace; 0 where none is."""
        slot = self._passed(played)
        if slot == self._newest % _CHECKPOINTS:
            return 0
        return self._mark_pace[(slot + 1) % _CHECKPOINTS]

    def _passed(self, played):
        """The slot of the last checkpoint played. Changes nothing: an interrupt may be retiring meanwhile, and may have
        gone beyond `played` since that was read; then it is one of those already retired."""
        number = self._oldest
        while ahead(played, self._mark_word[number % _CHECKPOINTS]) >= _HALF:
            number = (number - 1) & COUNT_MASK
        while number != self._newest:
            after = (number + 1) & COUNT_MASK
            if ahead(played, self._mark_word[after % _CHECKPOINTS]) >= _HALF:
                break
            number = after
        return number % _CHECKPOINTS

    def _walk(self, played):
        """(position, stepping words since the last checkpoint played)."""
        ring = self.ring
        axes = self.layout.axes
        slot = self._passed(played)
        position = array("i", [self._mark_position[slot * axes + axis] for axis in range(axes)])
        word = self._mark_word[slot]
        if self.drive is None:
            stepping = tally(ring.words, ring.mask, word, played, axes, position)
            return list(position), stepping
        stepping = 0
        while word != played:
            levels = ring.words[word & ring.mask] & self.layout.levels_mask
            moved = False
            for axis in range(axes):
                step = self.drive.stepped(axis, position[axis], levels)
                position[axis] += step
                moved = moved or step
            stepping += 1 if moved else 0
            word = (word + 1) & COUNT_MASK
        return list(position), stepping

    def _along(self, block, slot, stepping):
        """How far `block` is, `stepping` words after the checkpoint in `slot`."""
        if block is None:
            return stepping
        start = block.first if self._mark_ends[slot] else self._mark_index[slot]
        if block.kind == TRACK and block.walker.backward:
            stepping = -stepping
        return (start + stepping) & COUNT_MASK

    def place(self, played):
        """The place on the track under way when `played` words have appeared on the pins; None where there is none."""
        block = self.planner.playing()
        if block is None or block.kind != TRACK:
            return None
        return self._along(block, self._passed(played), self._walk(played)[1])

    def cancel(self, played):
        """After the player has halted, and with `open` cleared: drop all words not played, take their place as truth.

        Returns (position, block, index): the block that was under way, if any, and how many of its dominant steps
        have been made (of a track: the place), so that it can be taken up again. The planner keeps its blocks.
        """
        self.retire(played)
        position, stepping = self._walk(played)
        block = self.planner.playing()
        index = self._along(block, self._oldest % _CHECKPOINTS, stepping)
        self.ring.head = played
        self.ring.power.clear()
        for axis in range(self.layout.axes):
            self._position[axis] = position[axis]
        if self.drive is not None:
            self.drive.seek(position)
        self._levels &= ~self.layout.tool_mask
        self._reset(played)
        return position, block, index
