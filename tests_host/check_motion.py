"""Acceleration: limits kept, corners by the junction formula, ends exact, and hardly slower than a planner in floats."""

from passo.motion.block import LINE
from passo.motion.planner import Planner
from passo.steps.word import TICKS_PER_S
from programs import MM, Machine, end_of, hold_against_limits, hold_axes_against_limits, path_of, reference_seconds

CASES = {
    "check_limits": (("seed", "seed"), ("kind", "choice", "mixed", "lines", "tiny", "reversals", "arcs")),
    "check_start_speed": (("seed", "seed"), ("kind", "choice", "mixed", "lines", "reversals", "arcs"), ("start", 1, 40)),
    "check_feeding_changes_nothing": (("seed", "seed"),),
}
RUNS = {"check_limits": 60, "check_start_speed": 20, "check_feeding_changes_nothing": 8}


def check_limits(seed, kind):
    hold_limits(seed, kind)


def hold_limits(seed, kind):
    """Returns (blocks, segments, worst change of speed, worst steps too many in 20 ms, time, the reference's time)."""
    machine = Machine(seed, kind)
    words = machine.run()
    assert end_of(words) == machine.place
    if not machine.facts:
        return 0, 0, 0, 0, 0, 0
    worst = hold_against_limits(machine, machine.facts)
    assert worst <= 1.02, worst
    over = hold_axes_against_limits(machine, words)
    took = sum([segment[2] for segment in machine.segments]) / TICKS_PER_S
    best = reference_seconds(machine.facts)
    assert took <= best * 1.02 + 0.0005, (took, best)
    return len(machine.facts), len(machine.segments), worst, over, took, best


def check_start_speed(seed, kind, start):
    """Up to the start speed, in mm/s, there is no ramp; above it every change keeps the acceleration; the path is the same."""
    plain = Machine(seed, kind)
    path = path_of(plain.run())
    machine = Machine(seed, kind)
    machine.limited(machine.steps_per_m, machine.speeds, machine.accelerations, machine.deviation, start * MM)
    assert path_of(machine.run()) == path
    took = [sum([segment[2] for segment in each.segments]) for each in (plain, machine)]
    assert took[1] <= took[0] * 1.001 + 12_500
    before = 0, 0, 0
    for number, part, ticks in machine.segments:
        length, steps, top, acceleration, _ = machine.facts[number]
        seconds = ticks / TICKS_PER_S
        speed = part * length / steps / seconds
        grain = speed * 2 / ticks + 0.002 * min(top, 50) + 0.01 * speed
        assert speed <= top * 1.001 + grain
        allowed = (acceleration * seconds + before[2] * before[1]) / 2 * 1.02 + grain
        slower, faster = min(speed, before[0]), max(speed, before[0])
        assert faster <= max(slower, start) + allowed, (number, speed, before)
        if not before[0]:
            assert speed >= min(start, top) * 0.99 - grain
        before = speed, seconds, acceleration


def check_feeding_changes_nothing(seed):
    """The words do not depend on how far ahead the queue is filled, once the look-ahead is."""
    machine = Machine(seed, "tiny", 20)
    words = machine.run()
    other = Machine(seed, "tiny", 20)
    other.rig.planner.room = lambda: Planner.room(other.rig.planner) > 10 and 1
    assert other.run() == words


def check_first_step_from_rest_is_at_once():
    machine = Machine(5, "lines", 1)
    machine.facts, machine.place = [], [0, 0, 0]
    machine.add((LINE, (1000, 0, 0), 50 * MM))
    machine.rig.planner.flush()
    words = machine.rig.take(125_000)
    before = 0
    for ticks, levels in words:
        if levels & 1:
            break
        before += ticks
    assert before < 5 * 12_500
