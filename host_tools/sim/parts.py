"""Parts of the plant: a carriage between hard ends, a slotted barrier, a pen solenoid, a spindle.

Parts with events of their own have `due`, the tick of the next event or NEVER, and `run()`, which carries it out.
"""

import math

NEVER = float("inf")
CHATTER = 6  # pairs of false edges that a bouncing barrier gives at most
TICKS_PER_MS = 12_500
MARGIN_MM = 10  # from the end of the travel, and from the barrier's edge, to the hard end
_ENDLESS = 1 << 40  # steps


def is_endless(board, axis):
    """True if an axis turns without an end: a rotary one that homes at no sensor."""
    return board.get("rotary") == axis["name"] and axis["name"] not in (board.get("homing") or {}).get("sensors", ())


def pull_off_of(homing, axis):
    """Return the steps from the sensor to the origin of `axis`, by the board file's `homing`."""
    own = homing.get("each", {}).get(axis, {})
    return own.get("pull_off_steps", homing.get("pull_off_steps", 0))


def hard_ends(board, axis):
    """Return (lowest, highest) position of an axis, in steps from its origin."""
    homing = board.get("homing") or {}
    if is_endless(board, axis):
        return -_ENDLESS, _ENDLESS
    margin = axis["steps_per_m"] * MARGIN_MM // 1000
    low, high = -pull_off_of(homing, axis["name"]) - margin, axis["travel_steps"] + margin
    return (-high, -low) if axis["name"] in homing.get("high_end", "") else (low, high)


class Carriage:
    """Moves by whole steps between `low` and `high`. Pushed against an end the rotor stalls: the step is lost."""

    def __init__(self, name, position, low, high, report, play=0):
        self.name = name
        self.position = position
        self.low = low
        self.high = high
        self.lost = 0  # steps lost at the ends
        self.stall = 0  # steps to come that are lost
        self.play = play  # steps of the motor that are lost at each turn
        self._taken = 0  # steps of `play` taken up: all behind a move forth, none behind one back
        self._stalled = False
        self._report = report

    def move(self, tick, steps):
        """Move by steps; return True if the carriage moved. The first lost step of a stall is reported, all are counted."""
        if self.stall:
            self.stall -= 1
            self.lost += 1
            return False
        if self.play:
            free = self._taken + steps
            self._taken = min(max(free, 0), self.play)
            steps = free - self._taken
            if not steps:
                return False
        wanted = self.position + steps
        reached = min(max(wanted, self.low), self.high)
        if reached != wanted:
            self.lost += abs(wanted - reached)
            if not self._stalled:
                self._stalled = True
                self._report(tick, f"{self.name} ran into its hard end at {reached}")
        else:
            self._stalled = False
        moved = reached != self.position
        self.position = reached
        return moved


class Encoder:
    """Counts the turns of a motor: its carriage's steps since the start, four counts a pulse."""

    def __init__(self, carriage, pulses, steps, sign=1):
        self._carriage = carriage
        self._start = carriage.position
        self._counts, self._steps = 4 * pulses * sign, steps
        self.lost = 0  # counts that never came
        self._turn = 4 * pulses
        self._turned = 0

    def index_passed(self):
        """True if the index mark has passed since the last call."""
        at = (self._carriage.position - self._start) * self._counts // self._steps
        before, self._turned = self._turned, at
        return at != before and (at % self._turn == 0 or at // self._turn != before // self._turn)

    @property
    def count(self):
        """The counts that the firmware's encoder should read: those of the carriage, less the lost ones."""
        return (self._carriage.position - self._start) * self._counts // self._steps - self.lost


class Barrier:
    """A slotted optical barrier or a limit switch: broken, which is the active state, while the carriage is at `edge`
    or below; at `edge` or above, where it is at the `high` end.

    After each change it may chatter for up to `bounce_ticks`.
    """

    def __init__(self, name, edge, position, bounce_ticks, random, high=False):
        self.name = name
        self.last = edge - 1 if high else edge  # the last position on the low side
        self.below = position <= self.last
        self._high = high
        self.due = NEVER
        self._reading = self.below != high  # its output, chatter included
        self._chatter = []  # ticks of the false edges to come, last one first
        self._bounce_ticks = bounce_ticks
        self._random = random

    def cross_edge(self, tick):
        """Take the carriage across the edge, and plan the chatter of the output."""
        self.below = not self.below
        self._reading = self.below != self._high
        pairs = self._random.randint(1, CHATTER) if self._bounce_ticks else 0
        times = {tick + self._random.randint(1, self._bounce_ticks) for _ in range(2 * pairs)}
        if len(times) % 2:
            times.pop()
        self._chatter = sorted(times, reverse=True)
        self._plan_next()

    def pass_by(self):
        """Take the carriage across the edge while nothing plays: no chatter."""
        self.below = not self.below
        self._reading = self.below != self._high

    def run(self):
        """Turn the output round for the next false edge."""
        self._chatter.pop()
        self._reading = not self._reading
        self._plan_next()

    def is_active(self, tick):
        return self._reading

    def _plan_next(self):
        self.due = self._chatter[-1] if self._chatter else NEVER


class Noise:
    """Turns the level of an input round for a while, again and again."""

    def __init__(self, name):
        self.name = name
        self.flipped = 0
        self.due = NEVER
        self._ticks = []  # of the changes to come, the last one first

    def add_flips(self, ticks):
        """Flip the input at each of `ticks`; a spike is two of them."""
        self._ticks = sorted(self._ticks + list(ticks), reverse=True)
        self.due = self._ticks[-1] if self._ticks else NEVER

    def run(self):
        self._ticks.pop()
        self.flipped ^= 1
        self.due = self._ticks[-1] if self._ticks else NEVER


class Solenoid:
    """The pen's solenoid: the pen arrives, down (1000) or up (0), `on_ticks` or `off_ticks` after its pin changes."""

    def __init__(self, on_ticks, off_ticks):
        self.value = 0
        self.due = NEVER
        self._delays = off_ticks, on_ticks
        self._wanted = 0

    def switch_coil(self, tick, on):
        """Switch the coil at `tick`; the pen follows after the board file's delay."""
        self._wanted = 1000 if on else 0
        # Released before it has arrived, it falls back without having moved.
        self.due = tick + self._delays[on] if self._wanted != self.value else NEVER

    def run(self):
        """Have the pen arrive."""
        self.value = self._wanted
        self.due = NEVER


class Spindle:
    """A spindle that follows its speed by a ramp, and gives `pulses` a turn. `held`: the highest speed that it reaches, rpm."""

    RAMP_RPM_S = 20_000

    def __init__(self, pulses, max_rpm):
        self._per_turn = pulses
        self._max_rpm = max_rpm
        self._tick = 0
        self._asked = 0.0
        self._turns = 0.0
        self.rpm = 0.0
        self.held = math.inf
        self.unplugged = False  # the wire of the pulses: none come
        self._count, self._last = 0, 0  # pulses, and the tick of the last

    def set_level(self, tick, level):
        """From `tick` on it is asked for `level` of 1000 of its speed."""
        self.run(tick)
        self._asked = self._max_rpm * level / 1000

    def run(self, tick):
        """Move the rotor on to `tick`: its speed follows by RAMP_RPM_S."""
        seconds = (tick - self._tick) / 12_500_000
        self._tick = tick
        target = min(self._asked, self.held)
        before = self.rpm
        step = self.RAMP_RPM_S * seconds
        self.rpm = min(target, before + step) if before < target else max(target, before - step)
        ramp_s = abs(self.rpm - before) / self.RAMP_RPM_S
        self._turns += ((before + self.rpm) / 2 * ramp_s + self.rpm * (seconds - ramp_s)) / 60

    def count_pulses(self, tick):
        """Return (pulses since the start, tick of the last)."""
        self.run(tick)
        count = int(self._turns * self._per_turn)
        if count != self._count and not self.unplugged:
            self._count = count
            beyond = self._turns * self._per_turn - count
            self._last = tick - int(beyond / (self.rpm * self._per_turn / 60) * 12_500_000) if self.rpm else tick
        return self._count, self._last
