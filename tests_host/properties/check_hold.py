"""Hold, resume, cancel and overrides: the path stays the same to the step, and the limits are kept all the way."""

from math import sqrt

from draws import Random
from passo.records import KIND_ARC, KIND_LINE
from passo.steps.word import COUNT_MASK, TICKS_PER_S
from random_motion import MM, Machine, end_of, hold_against_limits, path_of

CASES = {
    "check_hold": (("seed", "seed"), ("kind", "choice", "mixed", "tiny", "arcs"), ("part", 0, 1000)),
    "check_many_holds": (("seed", "seed"), ("kind", "choice", "mixed", "tiny", "arcs")),
    "check_slows_at_once": (("seed", "seed"), ("kind", "choice", "line", "arc", "tiny"), ("part", 300, 700)),
    "check_cancel": (("seed", "seed"), ("kind", "choice", "mixed", "tiny", "arcs"), ("part", 0, 1000)),
    "check_override": (("seed", "seed"), ("kind", "choice", "mixed", "tiny", "arcs")),
}
RUNS = {"check_hold": 30, "check_many_holds": 15, "check_slows_at_once": 9, "check_cancel": 20, "check_override": 20}
EXAMPLES = {
    "check_slows_at_once": ((35133, "arc", 417),),  # 3·10⁻⁶ of the speed is left before the last step
    "check_override": ((316, "mixed"),),  # at twice the speed an arc's last steps can just take it away
}
LEAD_TICKS = 125_000  # of words ahead, where an interrupt makes them
TURN_TICKS = 25_000  # between two such interrupts


def check_hold(seed, kind, part):
    """Hold anywhere, stand, resume: the same path to the step, and the limits kept on the way down and up."""
    plain = Machine(seed, kind)
    path = path_of(plain.run())
    machine = Machine(seed, kind)
    turns = [0, 0]

    def each(machine):
        turns[0] += 1
        feeder = machine.rig.feeder
        if not feeder.hold and len(machine.segments) * 1000 >= len(plain.segments) * part and turns[1] == 0:
            feeder.hold = True
        elif feeder.hold and feeder.standing():
            turns[1] += 1
            if turns[1] > 3:
                feeder.hold = False

    words = machine.run(each)
    assert path_of(words) == path
    if machine.facts:
        assert hold_against_limits(machine, machine.facts) <= 1.02


def check_many_holds(seed, kind):
    """Hold and go on at random, also before the machine has come to its stand."""
    hold_at_random(Machine(seed, kind), path_of(Machine(seed, kind).run()), seed)


def hold_at_random(machine, path, seed):
    """The machine's programme with holds has `path`, and keeps its limits."""
    random = Random(seed + 2)

    def each(machine):
        if random.between(0, 3) == 0:
            machine.rig.feeder.hold = not machine.rig.feeder.hold

    assert path_of(machine.run(each)) == path
    if machine.facts:
        assert hold_against_limits(machine, machine.facts) <= 1.02


def check_slows_at_once(seed, kind, part):
    """With 10 ms of words ahead, as an interrupt makes them, a hold begins to slow within 20 ms, and stands in v / a.

    And in no more than two segments and the time of one step from rest to rest, because it stands between two steps only.
    """
    machine = Machine(seed, "lines", 1)
    random = machine.random
    speed, acceleration = random.between(20, 100), random.between(500, 3000)
    machine.limited([100_000] * 3, [200 * MM] * 3, [acceleration * MM] * 3, 10_000)
    length = speed * speed // acceleration + speed // 2  # mm: up, half a second, down
    if kind == "line":
        machine.program = [(KIND_LINE, (80 * length, 60 * length, 0), speed * MM)]
    elif kind == "arc":
        radius = max(100 * length // 6, 100 * speed * speed // acceleration + 100)
        machine.program = [(KIND_ARC, (0, 0, 0), speed * MM, (radius, 0), False)]
        length = radius * 628 // 10_000
    else:
        machine.program = [(KIND_LINE, (16, 12, 0), speed * MM)] * (5 * length)
    held = (length * 1000 // speed + 1000 * speed // acceleration) * part * (TICKS_PER_S // 1_000_000)
    rig = machine.rig
    machine.facts, machine.place = [], [0, 0, 0]
    todo = machine.program[:]
    now = made = 0
    while not rig.feeder.standing():
        while todo and rig.planner.room():
            machine.add(todo.pop())
        if not todo:
            rig.planner.flush()
        rig.feeder.fill(rig.played, LEAD_TICKS)
        rig.feeder.hold = now >= held
        now += TURN_TICKS
        while made < now and rig.played != rig.ring.head:
            made += rig.ring.words[rig.played & rig.ring.mask] >> rig.layout.bits
            rig.played = (rig.played + 1) & COUNT_MASK
    tick = 0
    before = cruise = slows = 0
    for number, path, ticks in machine.segments:
        here = path / ticks
        if tick < held:
            cruise = max(cruise, here)
        elif here < cruise * 0.998 and not slows:
            slows = tick
        assert not slows or here <= before * 1.01
        before = here
        tick += ticks
    assert slows - held <= TICKS_PER_S // 50, (slows - held) * 1000 / TICKS_PER_S
    length, steps, _, acceleration, _ = machine.facts[0]
    ideal = cruise * TICKS_PER_S * length / steps / acceleration
    took = (tick - slows) / TICKS_PER_S
    step = 2 * sqrt(1.1 * length / steps / acceleration)  # an arc's may be a little longer than its mean
    assert 0.98 * ideal - 0.002 <= took <= 1.01 * ideal + step + 0.002, (ideal, took, step)


def check_cancel(seed, kind, part):
    """Hold, drop what is left at the stand, and go on with something else: the place is exact, as after a cancelled jog."""
    machine = Machine(seed, kind, 20)
    rig = machine.rig
    machine.facts, machine.place = [], [0, 0, 0]
    todo = machine.program[:]
    words = []
    turns = 0
    held = 1 + part // 40
    while not rig.feeder.standing():
        while todo and rig.planner.room():
            machine.add(todo.pop(0))
        if not todo:
            rig.planner.flush()
        words += rig.take(LEAD_TICKS)
        turns += 1
        rig.feeder.hold = turns >= held
    feeder = rig.feeder
    feeder.open = False
    place = feeder.cancel(rig.played)
    rig.planner.clear()
    assert list(place) == end_of(words)
    feeder.hold = False
    feeder.open = True
    rig.planner.line((300, -200, 100), TICKS_PER_S, False)
    after = end_of(rig.run())
    assert after == [300, -200, 100]
    assert list(feeder.position(rig.played)) == [at + by for at, by in zip(place, after)]


def check_override(seed, kind):
    """Changes of the override never leave the path, and every change of speed is within the acceleration."""
    override_at_random(Machine(seed, kind), path_of(Machine(seed, kind).run()), seed)


def override_at_random(machine, path, seed):
    """The machine's programme with changes of the override has `path`, and keeps its limits."""
    random = Random(seed + 1)

    def each(machine):
        if random.between(0, 2) == 0:
            machine.rig.planner.override(random.choice((10, 50, 100, 150, 200)))

    assert path_of(machine.run(each)) == path
    facts = [(fact[0], fact[1], 2 * fact[2], fact[3], fact[4]) for fact in machine.facts]
    if facts:
        assert hold_against_limits(machine, facts) <= 1.02
