"""CoreXY: two motors on one belt. Ends exact for motors and axes, the limits of both kept, paths and speeds those of the axes."""

from math import sqrt

from draws import Random
from passo.motion.limits import Limits
from passo.options.kinematics import motion_corexy as corexy
from passo.options.kinematics.motion import Planner
from passo.records import KIND_LINE
from passo.steps.word import TICKS_PER_S
from random_motion import MM, Machine, end_of, hold_against_limits, hold_axes_against_limits, reference_seconds
from rig import Rig

CASES = {
    "check_both_spaces": (("seed", "seed"), ("kind", "choice", "mixed", "lines", "tiny", "reversals", "arcs")),
    "check_a_stop_amid_a_step": (("seed", "seed"),),
    "check_map": (("x", -100_000_000, 100_000_000), ("y", -100_000_000, 100_000_000), ("z", -9, 9)),
}
RUNS = {"check_both_spaces": 40, "check_a_stop_amid_a_step": 15}
WINDOW_TICKS = TICKS_PER_S // 50


class Belt(Machine):
    """A machine of random_motion.py on one belt. `steps_per_m` … are the motors', in lengths of the path; `own` are the axes'."""

    def make_rig(self):
        return Rig(axes=3, planner=Planner(3, {"kinematics": "corexy"}))

    def limited(self, steps_per_m, speeds, accelerations, deviation, start=0, jerk=0):
        self.own = steps_per_m, speeds, accelerations
        self.rig.planner.limits(Limits(steps_per_m, speeds, accelerations, deviation, start, jerk))
        root = sqrt(2)
        self.steps_per_m = [steps_per_m[0] * root, steps_per_m[0] * root, steps_per_m[2]]
        self.speeds = [min(speeds[:2]) / root] * 2 + speeds[2:]
        self.accelerations = [min(accelerations[:2]) / root] * 2 + accelerations[2:]
        self.deviation = deviation

    def _facts(self, move, steps):
        """Of the move as the motors see it; those of a line are within the axes' limits too."""
        move = (move[0], turned(move[1])) + move[2:]
        if move[0] == KIND_LINE:
            steps = max([abs(by) for by in move[1]])
        else:
            move = move[:3] + (turned(move[3] + (0,))[:2], not move[4]) + move[5:]
        facts = Machine._facts(self, move, steps)
        if move[0] == KIND_LINE:
            x, y, z = move[1]
            per_m, speeds, accelerations = self.own
            way = [by / (each / 1000) for by, each in zip(((x + y) / 2, (x - y) / 2, z), per_m)]
            length, _, speed, acceleration, _ = facts
            assert abs(sqrt(sum([part * part for part in way])) - length) <= length * 1e-9
            for axis in range(3):
                share = abs(way[axis]) / length
                assert speed * share <= speeds[axis] / MM * 1.00001 and acceleration * share <= accelerations[axis] / MM * 1.00001
        return facts


def turned(axes):
    x, y, z = axes
    return x + y, x - y, z


def axes_of(motors):
    a, b, z = motors
    assert (a + b) % 2 == 0
    return [(a + b) // 2, (a - b) // 2, z]


def hold_axes_by_windows(machine, words):
    """X and Y in each 20 ms: no further than at their highest speed, a step and a half of a motor aside."""
    per_m, speeds, _ = machine.own
    steps = machine.rig.steps_of(words)
    for axis in range(2):
        places, place = [], 0  # in halves of a step
        for tick, moves in steps:
            place += moves[0] + moves[1] * (-1 if axis else 1)
            places.append((tick, place))
        most = speeds[axis] * per_m[axis] / 1e9 * 2  # a second
        first = 0
        for tick, place in places:
            while tick - places[first][0] > WINDOW_TICKS:
                first += 1
            seconds = (tick - places[first][0]) / TICKS_PER_S
            assert abs(place - places[first][1]) <= most * 1.001 * seconds + 4, (axis, tick, place, places[first])


def check_both_spaces(seed, kind):
    """As check_limits of the other machines, for the motors; the axes by their own speeds."""
    hold_limits(seed, kind)


def hold_limits(seed, kind):
    """Returns what check_motion.hold_limits does, of the motors."""
    machine = Belt(seed, kind)
    words = machine.run()
    assert axes_of(end_of(words)) == machine.place
    if not machine.facts:
        return 0, 0, 0, 0, 0, 0
    worst = hold_against_limits(machine, machine.facts)
    assert worst <= 1, worst
    over = hold_axes_against_limits(machine, words)
    hold_axes_by_windows(machine, words)
    took = sum([segment[2] for segment in machine.segments]) / TICKS_PER_S
    best = reference_seconds(machine.facts)
    assert took <= best * 1.02 + 0.0005, (took, best)
    return len(machine.facts), len(machine.segments), worst, over, took, best


def check_a_stop_amid_a_step(seed):
    """Stopped anywhere the motors' position is exact, and the next line ends to the step where it is to."""
    machine = Belt(seed, "mixed")
    rig, planner = machine.rig, machine.rig.planner
    random = Random(seed + 1)
    machine.facts, machine.place = [], [0, 0, 0]
    place = [0, 0, 0]
    for _ in range(6):
        for move in machine.program[: planner.room() - 2]:
            machine.add(move)
        planner.flush()
        played = [word for _ in range(random.between(1, 4)) for word in rig.take(60_000)]
        del played
        motors = rig.feeder.cancel(rig.played)
        planner.clear()
        assert list(rig.feeder.position(rig.played)) == list(motors)
        planner.stand_at(motors)
        found = [0, 0, 0]
        corexy.to_axes(motors, found)
        a, b, z = motors
        assert found == [(a + b) // 2, (a - b) // 2, z]
        goal = [random.between(-500, 500) for _ in range(3)]
        planner.line([to - at for to, at in zip(goal, found)], 0, False)
        machine.place = place = goal
        rig.run()
        assert axes_of(rig.feeder.position(rig.played)) == place
        machine.facts = []


def check_map(x, y, z):
    motors, back = [0, 0, 0], [0, 0, 0]
    corexy.to_motors((x, y, z), motors)
    assert motors == [x + y, x - y, z]
    corexy.to_axes(motors, back)
    assert back == [x, y, z]
    corexy.to_axes(motors, motors)
    assert motors == back


def check_planes():
    assert corexy.arc_plane((0, 1, 2)) == ((0, 1, 2), True) and corexy.arc_plane((0, 1, -1)) == ((0, 1, -1), True)
    assert corexy.arc_plane((1, 0, 2)) == ((0, 1, 2), False)
    assert corexy.arc_plane((1, 2, 0)) is None and corexy.arc_plane((2, 0, 1)) is None
