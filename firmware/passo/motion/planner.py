"""The queue of blocks between the controller and the feeder, the rule by which they are let go, and their speeds.

    retired          fetched                     added          all count for ever, modulo 2²⁹
       |  being played  |  look-ahead: may change  |
    . [b b b b b b b b b b b b b b b b b b b b b b b] . .

A block is released to the feeder only when the look-ahead is full, or everything queued has been flushed: then the same
job gives the same ticks however fast it arrived. A fetched block stays in its place until its last word has been
played, because a hold may come back to it.

Without limits() every block keeps its programmed speed from first to last. With them each block also has the speed at
which it may be left: that of the corner, and no more than what the blocks behind it, the last of which ends at rest,
can slow
down from. Adding a block runs back over the look-ahead, only as far as something changes, and never over blocks that
may have been released: what a block does depends on the LOOK_AHEAD − 1 that follow it, however many have come. The
way up needs no
pass: the ramp speeds up as it can.

    planner.limits(Limits(steps_per_m, speeds, accelerations, junction_deviation))
    planner.line((400, 30, 0), ticks, tool=True)
    planner.arc((0, 200, 10), (0, 1, 2), (0, 100), speed_nm_s=20_000_000, tool=True)
    planner.override(120)
    planner.flush()

The main loop adds and flushes; the feeder, in an interrupt, fetches and retires.
"""

from array import array

from micropython import const

from passo.motion.block import ARC, FREE, LINE, ROW, TRACK, WAIT, Block, leave_of, set_leave
from passo.motion.integers import NM_PER_M, isqrt
from passo.motion.line import MAX_STEPS, Line
from passo.motion.profile import TICKS_PER_S, set_units, square_in_units

LOOK_AHEAD = const(64)
IN_FLIGHT = const(64)
_SIZE = const(128)  # both
_COUNT = const(0x1FFFFFFF)
LONGEST_TICKS = const(0x1FFFFFFF)  # of one wait, or of one dominant step: 43 s
FEED_PERCENT = (10, 200)
RAPID_PERCENT = (1, 100)


class Planner:
    def __init__(self, axes):
        self.axes = axes
        self.power = 0  # of the blocks added from now on: see Block
        self.dynamic = False
        self._asked = 0  # the speed that the last line or arc was added with, before any limit
        self.percent = array("i", [100, 100])  # overrides: of the feed, of rapid motion
        self._stride = ROW + axes
        self._rows = array("i", bytearray(4 * _SIZE * self._stride))  # of Block, one after the other
        self._walkers = [None] * _SIZE  # of ARC the circle's plan, made when first needed; of FREE and TRACK what is walked
        self._line = Line(axes)  # this and the circle are walked by one block at a time, the one fetched last
        self._circle = None  # made when first needed
        self._under_way = Block()  # the one fetched last
        self._playing = Block()
        self._new = Block()  # being added
        self._last = Block()  # the one before it
        self._passing = Block()  # where a pass is
        self._limits = None
        # For the passes, in nm/s and their squares.
        self._speeds = [0] * _SIZE  # as programmed
        self._fastest = [0] * _SIZE  # what the axes allow there
        self._corners = [0] * _SIZE  # what the corner at its beginning allows, squared; None: there is none
        self._reaches = [0] * _SIZE  # what the whole block can gain or lose, squared
        self._exits = [0] * _SIZE  # at its end, as planned, squared
        self.clear()

    def limits(self, limits):
        """Accelerate within `limits` (profile.Limits) from now on; None: not at all. Only while nothing is queued."""
        self._limits = limits

    def load_arcs(self):
        """Make ready for arcs; arc() does it where nobody has. They take a good part of a board's memory."""
        if self._circle is None:
            from passo.motion.circle import Circle

            self._circle = Circle(self.axes)

    def clear(self):
        """Forget every block. Only while the feeder is stopped."""
        self._added = self._flushed = self._fetched = self._retired = self._frozen = 0
        self._before = None  # the last block queued, where motion may go through to the next without a stand
        self._heading = None  # its direction at its end

    def room(self):
        """How many more blocks can be queued now."""
        return _SIZE - ((self._added - self._retired) & _COUNT)

    def empty(self):
        """True when every block has been played to its last word."""
        return self._added == self._retired

    # --- adding

    def line(self, deltas, ticks, tool, tag=0, rapid=False):
        """Queue the line `deltas` (steps), to last `ticks` at its programmed speed. A line of no steps is no block.

        `rapid`: the override of rapid motion counts for it. An axis's limit makes it slower. Raises ValueError where it
        has too many steps, or steps further apart than LONGEST_TICKS.
        """
        total = max([abs(delta) for delta in deltas])
        if not total:
            return
        if total > MAX_STEPS:
            raise ValueError("a line of more than %d steps" % MAX_STEPS)
        if ticks // total > LONGEST_TICKS:
            raise ValueError("steps more than 43 s apart")
        block = self._new
        block.kind = LINE
        block.rapid = 1 if rapid else 0
        heading = None
        if self._limits:
            length, heading = self._limits.vector(deltas)
            fastest = self._limits.along(self._limits.speeds, heading)
            acceleration = self._limits.along(self._limits.accelerations, heading)
            ticks = self._set_speeds(block, total << 10, max(ticks, 1), length, fastest, acceleration, heading)
        else:
            block.gain = 0
        block.ticks = max(ticks // total, 1)
        block.ticks_rest = ticks % total
        at = self._added % _SIZE * self._stride + ROW
        for axis in range(self.axes):
            self._rows[at + axis] = deltas[axis]
        self._add(block, tool, tag, heading)

    def arc(self, deltas, plane, center, tool, clockwise=False, turns=0, speed_nm_s=0, ticks=0, tag=0, rapid=False):
        """Queue an arc or helix from here to `deltas` (steps, all axes) about `center` (steps from here, in the plane).

        `plane`: (a, b, third axis or -1), counter-clockwise is from a to b; `turns`: full ones on top. Its speed along
        the path, or the `ticks` it lasts at that. On arcs v²/R stays within the weaker axis's acceleration. An arc too
        short for a step is no block. Raises ValueError for what cannot be walked as a circle: the plane's axes with
        different steps/mm, a radius of 0 or above 2²⁰ steps; arc.TooSteep for too steep a helix. Use chords() there.
        """
        from passo.motion import arc
        from passo.motion.circle import PLAN, STEPS

        steps_per_m = self._limits.steps_per_m if self._limits else None
        if steps_per_m is None:
            raise ValueError("an arc needs limits(), for its length")
        if steps_per_m[plane[0]] != steps_per_m[plane[1]]:
            raise ValueError("the plane's axes differ in steps/mm")
        self.load_arcs()
        plan = self._plan(PLAN)
        path, _ = arc.plan(plan, plane, center, deltas, clockwise, turns)
        if not plan[STEPS]:  # too short for a step along the circle
            length, _ = self._limits.vector(deltas)
            self.line(deltas, ticks or length * TICKS_PER_S // speed_nm_s, tool, tag, rapid)
            return
        flat = path * NM_PER_M // (steps_per_m[plane[0]] << 10)
        rise = deltas[plane[2]] * NM_PER_M // steps_per_m[plane[2]] if plane[2] >= 0 else 0
        length = isqrt(flat * flat + rise * rise)
        if not ticks:
            ticks = length * TICKS_PER_S // speed_nm_s
        if (ticks << 10) // path > LONGEST_TICKS:
            raise ValueError("steps more than 43 s apart")
        block = self._new
        block.kind = ARC
        block.rapid = 1 if rapid else 0
        fastest, acceleration = self._arc_limits(plane, center, flat, rise, length)
        start = self._tangent(plane, center, (0, 0), clockwise, flat, rise, length)
        end = self._tangent(plane, center, (deltas[plane[0]], deltas[plane[1]]), clockwise, flat, rise, length)
        ticks = self._set_speeds(block, path, max(ticks, 1), length, fastest, acceleration, start)
        block.ticks = max((ticks << 10) // path, 1)
        block.ticks_rest = ((ticks << 10) % path << 7) // path
        self._add(block, tool, tag, end)

    def _plan(self, size):
        """An array of `size` for the plan of the next arc: what is walked is kept by the place in the queue."""
        place = self._added % _SIZE
        if not isinstance(self._walkers[place], array):
            self._walkers[place] = array("i", bytearray(4 * size))
        return self._walkers[place]

    def wait(self, ticks, tool, tag=0):
        """Queue `ticks` (1 … LONGEST_TICKS) without a step, the tool bit as given from their start."""
        block = self._new
        block.kind = WAIT
        block.ticks = ticks
        block.ticks_rest = 0
        block.gain = 0
        self._add(block, tool, tag, None)

    def free(self, walker, tool, tag=0):
        """Queue axes that run independently: `walker` is a steps.timed.Timed with its axes set."""
        block = self._new
        block.kind = FREE
        block.gain = 0
        place = self._added % _SIZE
        self._walkers[place] = walker
        self._speeds[place] = 0  # each axis has its own
        self._add(block, tool, tag, None)

    def track(self, walker, tag=0):
        """Queue a walk over a track: `walker` is a steps.track_walker.TrackWalker that has begun. It has the tool too."""
        block = self._new
        block.kind = TRACK
        block.gain = 0
        place = self._added % _SIZE
        self._walkers[place] = walker
        self._speeds[place] = 0  # the walker knows it
        self._add(block, walker.tool, tag, None, walker.place)

    def _add(self, block, tool, tag, heading, first=0):
        block.tool = 1 if tool else 0
        block.tag = tag
        block.first = first
        block.power = self.power
        block.dynamic = 1 if self.dynamic else 0
        if self.dynamic and block.gain and self._asked > block.speed:
            block.power = self.power * block.speed // self._asked
        block.leave = 0
        place = self._added % _SIZE
        block.store(self._rows, place * self._stride)
        self._exits[place] = 0
        self._new = self._last  # it is filled again with the block after the next
        self._last = block
        self._before = block if block.gain else None
        self._heading = heading
        self._added = (self._added + 1) & _COUNT
        if self._before:
            self._look_back(False)

    def flush(self):
        """Nothing more is coming for now: release all that is queued. The last block ends at rest."""
        self._flushed = self._frozen = self._added
        self._before = None

    def override(self, percent, rapid=None):
        """Feed at `percent` (10 … 200) of the programmed speed, rapid motion at `rapid` percent, from now on."""
        self.percent[0] = max(FEED_PERCENT[0], min(percent, FEED_PERCENT[1]))
        if rapid is not None:
            self.percent[1] = max(RAPID_PERCENT[0], min(rapid, RAPID_PERCENT[1]))
        self._look_back(True)

    # --- speeds

    def _set_speeds(self, block, steps, ticks, length, fastest, acceleration, heading):
        """Set the block's speeds and its ramp; returns its ticks, more of them where an axis's limit asks for it."""
        self._asked = speed = length * TICKS_PER_S // ticks or 1
        if speed > fastest:
            speed = fastest
            ticks = -(-length * TICKS_PER_S // speed)
        block.speed = speed
        before = self._before
        place = self._added % _SIZE
        self._speeds[place] = speed
        self._fastest[place] = fastest
        self._reaches[place] = set_units(block, steps, ticks, length, fastest, acceleration, before)
        self._corners[place] = 0 if before is None else self._limits.corner(self._heading, heading)
        return ticks

    def _arc_limits(self, plane, center, flat, rise, length):
        """(highest speed, acceleration) along the path of an arc."""
        limits = self._limits
        steps = isqrt((center[0] * center[0] + center[1] * center[1]) << 20)  # of 2⁻¹⁰
        radius = steps * NM_PER_M // limits.steps_per_m[plane[0]] >> 10
        weaker = min(limits.accelerations[plane[0]], limits.accelerations[plane[1]])
        speed = min(limits.speeds[plane[0]], limits.speeds[plane[1]], isqrt(weaker * radius)) * length // flat
        acceleration = weaker * length // flat
        if rise:
            speed = min(speed, limits.speeds[plane[2]] * length // abs(rise))
            acceleration = min(acceleration, limits.accelerations[plane[2]] * length // abs(rise))
        return speed or 1, acceleration or 1

    def _tangent(self, plane, center, place, clockwise, flat, rise, length):
        """Direction of the arc at `place`, of 2³⁰."""
        x, y = place[0] - center[0], place[1] - center[1]
        radius = isqrt((x * x + y * y) << 40) or 1  # so fine that the direction's length is 1 to 10⁻⁶, on any radius
        sign = -1 if clockwise else 1
        heading = [0] * self.axes
        heading[plane[0]] = -sign * (y << 50) // radius * flat // length
        heading[plane[1]] = sign * (x << 50) // radius * flat // length
        if plane[2] >= 0:
            heading[plane[2]] = (rise << 30) // length
        return heading

    def _cap(self, place, rapid):
        """The speed that the programme and the override ask for in the block at `place`."""
        return min(self._speeds[place] * self.percent[rapid] // 100, self._fastest[place])

    def _look_back(self, all):
        """Raise the exits of the blocks that may still change, from the newest back, as far as one does; `all`: of all.

        An exit is never lowered, what is under way may count on it: the ramp itself slows down to a lower override.
        """
        number = self._added
        count = min((number - self._frozen) & _COUNT, LOOK_AHEAD)
        block = self._passing
        block.load(self._rows, (number - 1) % _SIZE * self._stride)
        gain, rapid = block.gain, block.rapid
        while count > 1:
            place = (number - 1) % _SIZE
            before = (number - 2) % _SIZE
            block.load(self._rows, before * self._stride)
            square = 0
            if gain and block.gain:
                square = min(self._cap(place, rapid), self._cap(before, block.rapid)) ** 2
                corner = self._corners[place]
                if corner is not None and corner < square:
                    square = corner
                square = min(square, self._exits[place] + self._reaches[place])
            if square > self._exits[before]:
                self._exits[before] = square
                self._set_leave((number - 2) & _COUNT, square_in_units(block, square, self._speeds[before]))
            elif not all:
                return
            gain, rapid = block.gain, block.rapid
            number -= 1
            count -= 1

    def _set_leave(self, number, leave):
        set_leave(self._rows, number % _SIZE * self._stride, leave)
        while (number + 1) & _COUNT == self._fetched:  # it is under way: it need not slow down as much as it thought
            self._under_way.leave = leave
            if (number + 1) & _COUNT == self._fetched:
                return
            number = (self._fetched - 1) & _COUNT  # an interrupt has just gone on to another block
            leave = leave_of(self._rows, number % _SIZE * self._stride)

    # --- fetching: may run in an interrupt

    def next(self, moving=False):  # ISR: no allocation
        """The next block released, or None. To a machine that is `moving` any block is released: it cannot
        stop here. It is the same object each time, and its walker stands at its beginning."""
        fetched = self._fetched
        if fetched == self._added:
            return None
        if fetched == self._flushed:
            if (self._added - fetched) & _COUNT < LOOK_AHEAD and not moving:
                return None
            self._flushed = (fetched + 1) & _COUNT
        self._fetched = (fetched + 1) & _COUNT
        block = self._under_way
        self._unpack(block, fetched % _SIZE)
        if block.kind == LINE:
            self._line.begin(self._rows, fetched % _SIZE * self._stride + ROW)
        elif block.kind == ARC:
            self._circle.load(self._walkers[fetched % _SIZE])
        return block

    def _unpack(self, block, place):  # ISR: no allocation
        block.load(self._rows, place * self._stride)
        kind = block.kind
        if kind == LINE:
            block.walker = self._line
        elif kind == ARC:
            block.walker = self._circle
        else:
            block.walker = None if kind == WAIT else self._walkers[place]

    def retire(self):  # ISR: no allocation
        """The oldest fetched block has been played to its last word."""
        self._retired = (self._retired + 1) & _COUNT

    def playing(self):
        """The oldest block not yet played to its last word, or None. The same object each time; where it is not the
        one under way in the feeder, its walker is not its own any more."""
        retired = self._retired
        if retired == self._fetched:
            return None
        place = retired % _SIZE
        block = self._playing
        self._unpack(block, place)
        block.speed = self._speeds[place] if self._limits else 0
        return block
