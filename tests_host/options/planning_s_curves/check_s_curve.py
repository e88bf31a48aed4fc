"""Limited jerk: S-curves that keep it, ends and path exact, accelerations kept, hardly slower than the formula has it.

Jerk is taken from the path: where it never exceeds J, |s(t + 3h) − 3s(t + 2h) + 3s(t + h) − s(t)| ≤ J · h³ for any t and h,
before the start and after the end too, where the machine stands.
"""

from math import sqrt

from check_hold import LEAD_TICKS, hold_at_random, override_at_random
from draws import Random
from passo.motion.limits import Limits
from passo.options.planning_s_curves.motion_block import cube_root, quotient, ratio, scale
from passo.records import KIND_ARC, KIND_LINE
from passo.steps.word import TICKS_PER_S
from random_motion import MM, Machine, end_of, hold_against_limits, hold_axes_against_limits, path_of

CASES = {
    "check_one_ramp": (("seed", "seed"), ("kind", "choice", "line", "line", "arc")),
    "check_speeds_up_over_blocks": (("seed", "seed"),),
    "check_programs": (("seed", "seed"), ("kind", "choice", "mixed", "lines", "tiny", "reversals", "arcs")),
    "check_hold": (("seed", "seed"), ("kind", "choice", "mixed", "lines", "tiny", "arcs")),
    "check_override": (("seed", "seed"), ("kind", "choice", "mixed", "tiny", "arcs")),
    "check_held_ramp": (("seed", "seed"), ("part", 100, 900)),
    "check_a_hold_stands": (("seed", "seed"), ("part", 1, 900)),
    "check_numbers": (("value", 0, 0x3FFFFFFF), ("by", 1, 0x3FFFFFFF), ("bits", 0, 14)),
}
RUNS = {
    "check_one_ramp": 25, "check_speeds_up_over_blocks": 5, "check_programs": 15, "check_hold": 8, "check_override": 8,
    "check_held_ramp": 10, "check_a_hold_stands": 20,
}  # fmt: skip
EXAMPLES = {"check_one_ramp": [(22471413, "line"), (11122991, "line")]}  # the jerk grew in segments of a few steps, and braking fell behind
NOT_QUICK = ("check_hold",)
GRAIN_STEPS = 64  # J · h³ is as many: a step's share in it is small
GRAIN = 1.5  # steps that s may be off: inside a step it is not known


def drawn(random, low, high):
    """Evenly on a scale of powers."""
    return int(low * (high / low) ** (random.between(0, 1000) / 1000))


class Smooth(Machine):
    """A machine with a jerk, mm/s³."""

    def __init__(self, seed, kind, jerk=0, blocks=None):
        Machine.__init__(self, seed, kind, blocks)
        self.jerk = jerk or drawn(Random(seed + 3), 500, 500_000)
        self.limited(self.steps_per_m, self.speeds, self.accelerations, self.deviation)

    def limited(self, steps_per_m, speeds, accelerations, deviation):
        Machine.limited(self, steps_per_m, speeds, accelerations, deviation)
        if hasattr(self, "jerk"):
            self.limits = Limits(steps_per_m, speeds, accelerations, deviation, 0, self.jerk * MM)
            self.rig.planner.limits(self.limits)
            self._listen_accelerated()

    def seconds(self):
        return sum([segment[2] for segment in self.segments]) / TICKS_PER_S


def alone(seed, kind="line"):
    """Return a machine with one ramp up and down to go, and its limits: (speed, acceleration, jerk, mm of a step)."""
    machine = Smooth(seed, "lines", blocks=1)
    random = machine.random
    speed, acceleration = drawn(random, 3, 200), drawn(random, 50, 3000)
    per_m = random.choice((80_000, 100_000, 400_000))
    machine.limited([per_m] * 3, [500 * MM] * 3, [acceleration * MM] * 3, 10_000)
    size = random.choice((20, 100, 500, 2000, 10_000))
    if kind == "arc":
        machine.program = [(KIND_ARC, (0, 0, 0), speed * MM, (size, 0), False)]
    else:
        machine.program = [(KIND_LINE, (size, 0, 0), speed * MM)]
    return machine, 1000 / per_m


def ramp_seconds(change, acceleration, jerk):
    if change >= acceleration * acceleration / jerk:
        return change / acceleration + acceleration / jerk
    return 2 * sqrt(change / jerk)


def ideal_seconds(length, speed, acceleration, jerk):
    """From rest to rest."""
    low, high = 0.0, speed
    for _ in range(60):
        if high * ramp_seconds(high, acceleration, jerk) <= length:
            break
        middle = (low + high) / 2
        if middle * ramp_seconds(middle, acceleration, jerk) <= length:
            low = middle
        else:
            high = middle
            if high - low < speed * 1e-9:
                high = low
    return ramp_seconds(high, acceleration, jerk) + length / high


def hold_jerk(machine, jerk, grain, first=0, last=1 << 30):
    """Check the jerk of the segments `first` up to `last`; return the worst, as a part of the limit."""
    times, places = [0.0], [0.0]
    for number, path, ticks in machine.segments[first:last]:
        length, steps, _, _, _ = machine.facts[number]
        times.append(times[-1] + ticks / TICKS_PER_S)
        places.append(places[-1] + path * length / steps)
    wide = (GRAIN_STEPS * grain / jerk) ** (1 / 3)
    ends = [0, 0, 0, 0]
    worst = 0.0
    start = 0.0 if first else -3 * wide
    end = times[-1] - (3 * wide if last < len(machine.segments) else 0)
    while start < end:
        s = []
        for i in range(4):
            at = start + i * wide
            while ends[i] < len(times) - 1 and times[ends[i]] < at:
                ends[i] += 1
            here = ends[i]
            if at <= 0 or not here:
                s.append(0.0)
            elif at >= times[-1]:
                s.append(places[-1])
            else:
                part = (at - times[here - 1]) / (times[here] - times[here - 1])
                s.append(places[here - 1] + part * (places[here] - places[here - 1]))
        third = abs(s[3] - 3 * s[2] + 3 * s[1] - s[0])
        worst = max(worst, (third - GRAIN * grain) / (GRAIN_STEPS * grain))
        start += wide / 3
    return worst


def check_one_ramp(seed, kind):
    """Up and down within one block: jerk and acceleration kept, end exact, time within 2 % of the formula's, two steps."""
    machine, step = alone(seed, kind)
    words = machine.run()
    assert end_of(words) == machine.place
    length, _, speed, acceleration, _ = machine.facts[0]
    assert hold_against_limits(machine, machine.facts) <= 1.02
    worst = hold_jerk(machine, machine.jerk, step)
    assert worst <= 1.05, worst
    took, best = machine.seconds(), ideal_seconds(length, speed, acceleration, machine.jerk)
    one = min(step / speed, (6 * step / machine.jerk) ** (1 / 3))
    assert took <= best * 1.02 + 2 * one + 0.0005, (took, best, one)


def check_speeds_up_over_blocks(seed):
    """A line in many pieces is begun as one in one piece, and its jerk is kept as long as it gains speed."""
    whole, step = alone(seed)
    whole.program = [(KIND_LINE, (4000, 0, 0), whole.program[0][2])]
    whole.run()
    pieces, _ = alone(seed)
    pieces.program = [(KIND_LINE, (8, 0, 0), whole.program[0][2])] * 500
    pieces.run()
    fastest = 0.0
    last = 0  # the segments up to the fastest: slowing down over several blocks may set in harder
    for at in range(len(pieces.segments)):
        number, path, ticks = pieces.segments[at]
        if path / ticks > fastest:
            fastest = path / ticks
            last = at + 1
        elif path / ticks < 0.98 * fastest:
            break
    worst = hold_jerk(pieces, pieces.jerk, step, 0, last)
    assert worst <= 1.1, worst  # pieces of 8 steps: one in a thousand comes to 1.07
    plain = Machine(seed, "lines", 1)
    plain.limited(whole.steps_per_m, whole.speeds, whole.accelerations, 10_000)
    plain.program = pieces.program
    plain.run()
    seconds = sum([segment[2] for segment in plain.segments]) / TICKS_PER_S  # at the speed that the look-ahead allows
    acceleration = pieces.facts[0][3]
    assert pieces.seconds() <= max(whole.seconds(), seconds) * 1.01 + acceleration / pieces.jerk + 0.002
    assert hold_against_limits(pieces, pieces.facts) <= 1.02


def check_programs(seed, kind):
    """The path is that without it to the step, all limits are kept, and nothing becomes quicker by it."""
    plain = Machine(seed, kind)
    path = path_of(plain.run())
    machine = Smooth(seed, kind)
    words = machine.run()
    assert path_of(words) == path
    if machine.facts:
        assert hold_against_limits(machine, machine.facts) <= 1.02
        hold_axes_against_limits(machine, words)
        assert machine.seconds() >= sum([segment[2] for segment in plain.segments]) / TICKS_PER_S * 0.99 - 0.002


def check_hold(seed, kind):
    """Hold and go on at random, also before the machine has come to its stand: the same path."""
    hold_at_random(Smooth(seed, kind), path_of(Machine(seed, kind).run()), seed)


def check_override(seed, kind):
    """Changes of the override never leave the path, nor exceed the acceleration."""
    override_at_random(Smooth(seed, kind), path_of(Machine(seed, kind).run()), seed)


def check_held_ramp(seed, part):
    """One hold at any place of a ramp up and down: jerk is kept on the way to the stand and from it."""
    plain, _ = alone(seed)
    plain.run()
    machine, step = alone(seed)
    machine.facts, machine.place = [], [0, 0, 0]
    machine.add(machine.program[0])
    rig = machine.rig
    rig.planner.flush()
    held = False
    words = []
    for _ in range(100_000):
        if not held and len(machine.segments) * 1000 >= len(plain.segments) * part:
            held = rig.feeder.hold = True
        words += rig.take(LEAD_TICKS if held else 2)
        rig.feeder.retire(rig.played)
        if rig.planner.empty():
            break
        if held and rig.feeder.standing():
            rig.feeder.hold = False
    assert end_of(words) == machine.place
    assert hold_against_limits(machine, machine.facts) <= 1.02
    worst = hold_jerk(machine, machine.jerk, step)
    assert worst <= 1.1, worst


def check_a_hold_stands(seed, part):
    """One hold while the machine gains speed, below the speed of the block's end: it stands as quickly as jerk and acceleration allow."""
    random = Random(seed)
    machine = Smooth(seed, "lines", drawn(random, 2000, 50_000), 1)
    acceleration, speed = random.between(200, 1000), random.between(20, 60)
    machine.limited([100_000] * 3, [200 * MM] * 3, [acceleration * MM] * 3, 10_000)
    seconds = speed / acceleration + acceleration / machine.jerk
    length = int(speed * seconds) + 2
    machine.facts, machine.place = [], [0, 0, 0]
    for _ in range(2):
        machine.add((KIND_LINE, (80 * length, 60 * length, 0), speed * MM))
    rig = machine.rig
    rig.planner.flush()
    made = 0
    while made < seconds * TICKS_PER_S * part / 1000:
        made += sum([word[0] for word in rig.take(1)])
    rig.feeder.hold = True
    stands = 0
    while not rig.feeder.standing():
        stands += sum([word[0] for word in rig.take(2)])
        assert stands <= (2 * seconds + 0.3) * TICKS_PER_S
    assert hold_against_limits(machine, machine.facts) <= 1.02


def check_numbers(value, by, bits):
    assert scale(value, bits) == min(value << bits, 0x3FFFFFFF)
    assert scale(value, -bits) == value >> bits
    exact = min((value << bits) // by, 0x3FFFFFFF)
    assert abs(quotient(value, by, bits) - exact) <= 1 + (exact >> 9) + (((1 << bits) - 1) if by >= 0x200000 else 0)
    assert abs(ratio(value, by) - value * 16384 // (value + by)) <= 4
    push = value + 1
    true = (push * 0.75 * (1 << 17)) ** (1 / 3)
    assert abs(cube_root(push) - true) <= 1 + true / 200
