"""The queue of blocks between the controller and the feeder, the rule by which they are let go, and their speeds.

    retired          fetched                     added          all count for ever, modulo 2²⁹
       |  being played  |  look-ahead: may change  |
    . [b b b b b b b b b b b b b b b b b b b b b b b] . .

A block is released to the feeder only when the look-ahead is full, or everything queued has been flushed: then the same
job gives the same ticks however fast it arrived. With SCRATCH_EAGER it is also released while the one before still plays: the machine
does not wait for a full look-ahead. A fetched block stays in its place until its last word has been played: a hold may come back.

Without limits() every block keeps its programmed speed from first to last. With them each block also has an exit speed: at most that of the
corner (junction deviation), and the speed from which the blocks behind it can slow down, the last of which ends at rest
(look_ahead_viper.py has the picture). Adding a block runs back over the look-ahead, only as far as something changes, and never over blocks
that may have been released: a block's speeds depend on the LOOK_AHEAD − 1 that follow it, however many have come.

    planner.limits(Limits(steps_per_m, speeds, accelerations, junction_deviation))
    planner.line((400, 30, 0), 0, tool=True, speed_nm_s=20_000_000)
    planner.flush()

The main loop adds and flushes; the feeder, in an interrupt, fetches and retires.
"""

from array import array

import micropython
from micropython import const

from passo.arrays import zeros
from passo.motion.limits import MOST
from passo.motion.line import LONGEST_TICKS, Line, Steady, dominant, refuse
from passo.motion.row_viper import close, room, take
from passo.motion.speed_viper import q_of
from passo.records import *

LOOK_AHEAD = const(64)
FEED_PERCENT = (10, 200)
RAPID_PERCENT = (1, 100)


class Block:
    """The block fetched last. The planner fills it in again and again, so nothing is allocated when one is fetched."""

    def __init__(self, rows):
        self.kind = KIND_WAIT
        self.walker = None  # its geometry: the planner's line or circle, or one that a feature has queued by walk(); None of a wait
        self.start = 0  # q at which it may be begun and ended without a ramp
        self.rows = rows  # its row begins at rows[at]
        self.at = 0


class Planner:
    def __init__(self, axes):
        self.axes = axes
        self._stride = ROW_STEPS + axes
        self.rows = zeros(QUEUE_SIZE * self._stride)  # ROW_…, and the deltas of each axis
        self._walkers = [None] * QUEUE_SIZE  # of an arc the index of its plan in Plans.plans; of a walker with its own pace the walker
        self._plan_arc = self._set_arc_speed = self._limit_jerk = None
        self._arcs = None  # their plans; made by load()
        self._line = Line(axes)  # this and the circle are walked by one block at a time, the one fetched last
        self.line_state = self._line.state
        self._circle = None  # made by load()
        self.ramp = Steady()  # the feeder's; a Ramp after load()
        self.indices = array("i", [0] * QUEUE_FIELDS)
        self._under_way = Block(self.rows)
        self.scratch = array("i", bytearray(4 * SCRATCH_FIELDS))
        self.percent = memoryview(self.scratch)[SCRATCH_PERCENT : SCRATCH_PERCENT + 2]  # overrides: of the feed, of rapid motion
        self.percent[0] = self.percent[1] = 100
        self.scratch[SCRATCH_STRIDE] = self._stride
        self.scratch[SCRATCH_SIZE] = QUEUE_SIZE
        self.scratch[SCRATCH_FACTOR] = self.scratch[SCRATCH_FACTOR + 1] = 4096
        self.accelerates = False  # it has limits
        self.ready = False  # lines() may be asked for: no axis is so slow that it would refuse one
        self._limits = None
        self._fields = None  # of the limits
        self.arrays = None  # the arguments of plan_lines(), one tuple until there are other limits
        self._plan_block = self._corner = self._plan_lines = self._look_back = None  # the functions that work with them
        self.batch = array("i", bytearray(4 * BATCH_FIELDS * BATCH_ROWS))  # of lines to be queued
        self.clear()

    def limits(self, limits):
        """Accelerate within `limits` (limits.Limits) from now on; None: not at all. Only after load(), and while nothing is
        queued. Returns what the planner reckons with."""
        if limits is not None:
            ramp = self.ramp
            if self._limit_jerk and (limits.jerk or ramp.s_curve):
                self._limit_jerk(ramp, limits, self._stride, len(self.rows))
        self._limits = limits
        self._fields = limits.fields if limits else None
        self.arrays = self.rows, self.scratch, self.indices, self._fields
        self.scratch[SCRATCH_START] = limits.start if limits else 0
        self.accelerates = limits is not None
        self.ready = self.accelerates and limits.ready
        self.scratch[SCRATCH_FEED] = self.scratch[SCRATCH_GIVEN] = self.scratch[SCRATCH_ASKED] = 0
        return limits

    def load(self, jerk_limit=None):
        """Make ready for limits() and arcs, before there is a feeder. `jerk_limit`: an option's limit(ramp, limits, stride, size)."""
        from passo.motion.arc import Plans, plan
        from passo.motion.arc_speed import set_speed
        from passo.motion.block_viper import plan_block
        from passo.motion.circle import Circle
        from passo.motion.look_ahead_viper import corner, look_back, plan_lines
        from passo.motion.ramp import Ramp

        self._plan_block, self._corner, self._plan_lines, self._look_back = plan_block, corner, plan_lines, look_back
        self.ramp = Ramp()
        self._circle = Circle(self.axes)
        self._plan_arc, self._set_arc_speed, self._limit_jerk = plan, set_speed, jerk_limit
        self._arcs = Plans()

    def clear(self):
        """Forget every block; the power is 0. Only while the feeder is stopped."""
        self.power = 0
        self.dynamic = False  # see set_power()
        for which in range(len(self.indices)):
            self.indices[which] = 0
        self.indices[QUEUE_ARC] = -1
        if self._arcs and self._arcs.used:
            self._arcs.clear()
        self.scratch[SCRATCH_TAKEN] = self.scratch[SCRATCH_LASTS]
        self.scratch[SCRATCH_THROUGH] = 0  # 1: motion may go through from the last block queued to the next without a stand

    @micropython.native
    def room(self):
        """Return how many more blocks can be queued now; 0 while the next arc has no free slot."""
        return room(self.indices)

    def empty(self):
        """Return True when every block has been played to its last word."""
        indices = self.indices
        return indices[QUEUE_ADDED] == indices[QUEUE_RETIRED]

    def ahead(self):
        """Return how many blocks are queued behind the one under way."""
        indices = self.indices
        return (indices[QUEUE_ADDED] - indices[QUEUE_FETCHED]) & COUNT_MASK

    def set_power(self, power, dynamic):
        """Analogue power, 0 … 1000, of the blocks added from now on; `dynamic`: in proportion to the speed."""
        self.power = power
        self.dynamic = dynamic

    def slowest(self, axes):
        """Return the speed of the slowest axis, in nm/s; and the accelerations of these axes, in nm/s²."""
        return min(self._limits.speeds), [self._limits.accelerations[axis] for axis in axes]

    # --- adding

    def line(self, deltas, ticks, tool, tag=0, rapid=False, speed_nm_s=0):
        """Queue the line `deltas` (steps), to last `ticks` at its programmed speed. A line of no steps is no block.

        With limits `ticks` may be 0: then its speed along the path is given, or, that being 0 as well, it is as fast as
        the axes may be. `rapid`: the override of rapid motion counts for it. An axis's limit makes it slower. Raises
        ValueError where it has too many steps, or steps further apart than LONGEST_TICKS.
        """
        at = self.indices[QUEUE_ADDED] % QUEUE_SIZE * self._stride
        rows = self.rows
        for axis in range(self.axes):
            rows[at + ROW_STEPS + axis] = deltas[axis]
        if self._fields is None:
            if not self._steady(at, deltas, ticks):
                return
        else:
            scratch = self.scratch
            scratch[SCRATCH_IS_ARC] = 0
            if speed_nm_s != scratch[SCRATCH_ASKED] or ticks:
                self._ask(deltas, ticks, speed_nm_s)
            result = self._plan_block(rows, at, scratch, self._fields)
            if result <= 0:
                if result:
                    refuse(result)
                return
            self._corner(rows, at, scratch, self._fields)
        self._add(at, KIND_LINE, tool, tag, rapid)

    def lines(self, done, count):
        """Queue rows `done` … count − 1 of `batch`, for which there is room, and none of which line() would refuse: also if the
        machine's speeds are beyond what machine code reckons with."""
        batch = self.batch
        while done < count:
            self._ask(None, 0, batch[done * BATCH_FIELDS + BATCH_FEED])
            done = self._plan_lines(batch, done, count, *self.arrays)
            if done < 0:
                refuse(done)

    def _ask(self, deltas, ticks, speed_nm_s):
        """Write the speed along the path asked for, nm/s, or the ticks to scratch, for plan_block()."""
        scratch = self.scratch
        limits = self._limits
        if ticks:
            speed_nm_s = limits.length(deltas) * TICKS_PER_S // ticks or 1
        scratch[SCRATCH_GIVEN_SHIFT] = 0
        while ticks > LONGEST_TICKS:
            ticks >>= 1
            scratch[SCRATCH_GIVEN_SHIFT] += 1
        scratch[SCRATCH_GIVEN] = ticks
        scratch[SCRATCH_FEED] = min(limits.part(speed_nm_s), MOST) if speed_nm_s else 0
        scratch[SCRATCH_ASKED] = -1 if ticks or speed_nm_s > FASTEST_NM_S else speed_nm_s  # beyond, it is asked for each time

    def fits(self, deltas, ticks, speed_nm_s):
        """Raise ValueError if line() would refuse this line. Queues nothing. Allocates: not for an interrupt."""
        if self._fields is None:
            dominant(deltas, ticks)
            return
        self._ask(deltas, ticks, speed_nm_s)
        row = array("i", bytearray(4 * self._stride))
        for axis in range(self.axes):
            row[ROW_STEPS + axis] = deltas[axis]
        scratch = self.scratch[:]
        scratch[SCRATCH_IS_ARC] = 0
        result = self._plan_block(row, 0, scratch, self._fields)
        if result < 0:
            refuse(result)

    def _steady(self, at, deltas, ticks):
        """Measure a line without limits: its speed from first to last. False if it has no steps."""
        total = dominant(deltas, ticks)
        if not total:
            return False
        self._stand(at, max(ticks // total, 1))
        self.rows[at + ROW_TICKS_REST] = ticks % total
        return True

    def _stand(self, at, ticks):
        """Set the row of a block without acceleration."""
        rows = self.rows
        rows[at + ROW_TICKS] = ticks
        rows[at + ROW_TICKS_REST] = rows[at + ROW_GAIN] = rows[at + ROW_SPEED] = 0
        self.scratch[SCRATCH_THROUGH] = 0

    def arc(self, deltas, plane, center, tool, clockwise=False, turns=0, speed_nm_s=0, ticks=0, tag=0, queued=True,
            over_half=None):
        """Queue an arc or helix from here to `deltas` (steps, all axes) about `center` (steps from here, in the plane).

        `plane`: (a, b, third axis or -1), counter-clockwise is from a to b; `turns`: full ones on top; `over_half`: as of arc.plan(). Its
        speed along the path, or the `ticks` it lasts at that. On arcs v²/R stays within the axes' accelerations. An arc too short for a
        step along the circle is a line. Raises ValueError if it cannot be walked as a circle: the plane's axes with different steps/mm, a
        radius above 2²⁰ steps; arc.TooSteep for too steep a helix. `queued`: False only looks whether it would raise; there has to be room
        for it.
        """
        limits = self._limits
        if limits is None or self._arcs is None:
            raise ValueError("an arc needs load() and limits(), for its length")
        if limits.steps_per_m[plane[0]] != limits.steps_per_m[plane[1]]:
            raise ValueError("the plane's axes differ in steps/mm")
        plan = self._arcs.plan
        path, swept = self._plan_arc(plan, plane, center, deltas, clockwise, turns, over_half)
        if not plan[ARC_STEPS]:
            if queued:
                self.line(deltas, ticks, tool, tag, False, speed_nm_s)
            else:
                self.fits(deltas, ticks, speed_nm_s)
            return
        at = self.indices[QUEUE_ADDED] % QUEUE_SIZE * self._stride
        self.scratch[SCRATCH_ASKED] = -1
        scratch = self.scratch if queued else self.scratch[:]
        if not self._set_arc_speed(
            self.rows, at, scratch, limits, plan, path, swept, plane, center, deltas, clockwise, speed_nm_s, ticks
        ):
            refuse(-1)
        if queued:
            number = self.indices[QUEUE_ADDED]
            self._walkers[number % QUEUE_SIZE] = self._arcs.store(number)
            self.indices[QUEUE_ARC] = self._arcs.oldest
            self._add(at, KIND_ARC, tool, tag)
            if not room(self.indices):
                self.start()  # no more can come before it moves

    def wait(self, ticks, tool, tag=0):
        """Queue `ticks` (1 … LONGEST_TICKS) without a step, the tool bit as given from their start."""
        at = self.indices[QUEUE_ADDED] % QUEUE_SIZE * self._stride
        self._stand(at, ticks)
        self._add(at, KIND_WAIT, tool, tag)

    def walk(self, walker, tool, tag=0):
        """Queue what paces itself: a walker that has been set, or has begun."""
        at = self.indices[QUEUE_ADDED] % QUEUE_SIZE * self._stride
        self._stand(at, 0)
        self._walkers[self.indices[QUEUE_ADDED] % QUEUE_SIZE] = walker
        self._add(at, walker.kind, tool, tag, False, walker.index)

    @micropython.native
    def _add(self, at, kind, tool, tag, rapid=False, first=0):
        """Queue the block whose row begins at rows[at], and plan again the exits of those before it if motion goes through."""
        flags = 1 if tool else 0
        if rapid:
            flags |= 2
        if self.dynamic:
            flags |= 4
        rows = self.rows
        indices = self.indices
        scratch = self.scratch
        if close(rows, at, scratch, indices, kind, flags, tag, self.power, first):
            self._look_back(rows, scratch, indices)

    def flush(self):
        """Nothing more is coming for now: release all that is queued. The last block ends at rest."""
        self.indices[QUEUE_FLUSHED] = self.indices[QUEUE_FROZEN] = self.indices[QUEUE_ADDED]
        self.scratch[SCRATCH_THROUGH] = 0
        if self.scratch[SCRATCH_EAGER] > 1:
            self.stream(False)

    def stream(self, on):
        """Line after line is coming, or no longer: while they do, a queue that runs short slows the machine down."""
        if self.scratch[SCRATCH_EAGER]:
            self.scratch[SCRATCH_EAGER] = 2 if on else 1

    def start(self):
        """Release all that is queued, more of which may follow in time: the last block ends at rest only if none does."""
        self.indices[QUEUE_FLUSHED] = self.indices[QUEUE_ADDED]

    def override(self, percent, rapid=None):
        """Feed at `percent` (10 … 200) of the programmed speed, rapid motion at `rapid` percent, from now on."""
        self.percent[0] = max(FEED_PERCENT[0], min(percent, FEED_PERCENT[1]))
        if rapid is not None:
            self.percent[1] = max(RAPID_PERCENT[0], min(rapid, RAPID_PERCENT[1]))
        for which in range(2):
            self.scratch[SCRATCH_FACTOR + which] = self.percent[which] * self.percent[which] * 4096 // 10_000
        if self.accelerates:  # no exit is lowered, what is under way may count on it: the ramp itself slows down
            self.scratch[SCRATCH_ALL] = 1
            self._look_back(self.rows, self.scratch, self.indices)
            self.scratch[SCRATCH_ALL] = 0

    # --- fetching: may run in an interrupt

    @micropython.native
    def next(self, moving=False):  # ISR: no allocation
        """Return the next block released, or None. To a machine that is `moving` any block is released: it cannot
        stop here. It is the same object each time, and its walker stands at its beginning."""
        rows = self.rows
        at = take(rows, self.scratch, self.indices, 1 if moving else 0, 0)
        if at < 0:
            return None
        block = self._under_way
        kind = rows[at + ROW_KIND]
        walker = None
        if kind == KIND_LINE:
            walker = self._line
            walker.load(rows, at + ROW_STEPS)
        elif kind == KIND_ARC:
            walker = self._circle
            walker.load(self._arcs.plans, self._walkers[at // self._stride])
        elif kind != KIND_WAIT:
            walker = self._walkers[at // self._stride]
        block.kind = kind
        block.at = at
        block.walker = walker
        start = self.scratch[SCRATCH_START]
        block.start = q_of(start, rows, at, rows[at + ROW_LIMIT]) if start and rows[at + ROW_GAIN] else 0
        return block

    def row(self):
        """Return the index in `rows` of the oldest block not yet played to its last word; -1: there is none."""
        indices = self.indices
        retired = indices[QUEUE_RETIRED]
        return -1 if retired == indices[QUEUE_FETCHED] else retired % QUEUE_SIZE * self._stride

    def last(self, back=0):
        """Return the index in `rows` of the block that was played last, or of the one `back` before it; if they were played to their end."""
        return (self.indices[QUEUE_RETIRED] - 1 - back) % QUEUE_SIZE * self._stride

    def walker(self, at):
        """Return the geometry that walk() queued in the row that begins at rows[at]."""
        return self._walkers[at // self._stride]
