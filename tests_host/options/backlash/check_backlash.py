"""Lost motion: a carriage that follows its motor only after the play ends to the step, the limits hold, and the position reported is the carriage's."""

from draws import Random
from passo.options.backlash import motion as backlash
from passo.records import KIND_LINE, QUEUE_ADDED, ROW_STEPS, TICKS_PER_S
from random_motion import MM, Machine, hold_against_limits, hold_axes_against_limits, reference_seconds
from rig import Rig

CASES = {
    "check_limits": (("seed", "seed"), ("kind", "choice", "mixed", "lines", "tiny", "reversals")),
    "check_what_is_told": (("seed", "seed"), ("kind", "choice", "mixed", "lines", "tiny", "reversals")),
    "check_a_change_of_play": (("seed", "seed"),),
}
EXAMPLES = {"check_limits": [(282, "tiny"), (356, "lines")]}  # an axis at its highest speed, behind a line of which it has the lesser share
RUNS = {"check_limits": 16, "check_what_is_told": 15, "check_a_change_of_play": 10}


class Played(Machine):
    """A machine of random_motion.py with play. Its arcs are left out: their chords are lines. Facts are of the motors' blocks."""

    def value(self, number):
        return self.um[number - 160]

    def make_rig(self):
        self.um = [self.random.choice((0, 3, 25, 60, 400)) for _ in range(3)]
        planner = backlash.Planner(3, {"additions": self})
        rig = Rig(axes=3, planner=planner)
        planner.follow_motors(lambda: rig.feeder.position_view(rig.played))
        return rig

    def __init__(self, seed, kind):
        Machine.__init__(self, seed, kind)
        self.program = [move for move in self.program if move[0] == KIND_LINE]
        self.play = [(um * per_m + 500_000) // 1_000_000 for um, per_m in zip(self.um, self.steps_per_m)]

    def add(self, move):
        planner = self.rig.planner
        begun = planner.indices[QUEUE_ADDED]
        planner.line(move[1], 0, False, speed_nm_s=move[2])
        self.place = [self.place[axis] + move[1][axis] for axis in range(3)]
        added = planner.indices[QUEUE_ADDED] - begun
        assert added <= 2
        for number in range(begun, begun + added):
            row = number % len(planner._walkers) * planner._stride + ROW_STEPS
            ways = tuple([int(way) for way in planner.rows[row : row + 3]])
            self.facts.append(self._facts((KIND_LINE, ways, move[2]), max([abs(way) for way in ways])))


class Carriages:
    """The play as it is, by itself: between −play and 0 behind the motor."""

    def __init__(self, play):
        self.play, self.taken, self.place = play, [0, 0, 0], [0, 0, 0]

    def follow(self, rig, words):
        for _, moves in rig.steps_of(words):
            for axis in range(3):
                free = self.taken[axis] + moves[axis]
                self.taken[axis] = min(max(free, 0), self.play[axis])
                self.place[axis] += free - self.taken[axis]


def check_limits(seed, kind):
    hold_limits(seed, kind)


def hold_limits(seed, kind):
    """Returns what check_motion.hold_limits does."""
    machine = Played(seed, kind)
    words = machine.run()
    carriages = Carriages(machine.play)
    carriages.follow(machine.rig, words)
    assert carriages.place == machine.place
    if not machine.facts:
        return 0, 0, 0, 0, 0, 0
    worst = hold_against_limits(machine, machine.facts)
    assert worst <= 1, worst
    over = hold_axes_against_limits(machine, words)
    took = sum([segment[2] for segment in machine.segments]) / TICKS_PER_S
    best = reference_seconds(machine.facts)
    assert took <= best * 1.02 + 0.0005, (took, best)
    return len(machine.facts), len(machine.segments), worst, over, took, best


def told(machine):
    rig = machine.rig
    rig.feeder.retire(rig.played)
    return list(rig.planner.to_axes(rig.feeder.position(rig.played)))


def check_what_is_told(seed, kind):
    """At any word the position told is where the carriages are; stopped there, too, and the next line ends where it is to."""
    machine = Played(seed, kind)
    rig, planner = machine.rig, machine.rig.planner
    random = Random(seed + 1)
    machine.facts, machine.place = [], [0, 0, 0]
    carriages = Carriages(machine.play)
    todo = list(machine.program)
    while todo or not planner.empty():
        while todo and planner.room():
            machine.add(todo.pop(0))
        planner.flush()
        rig.feeder.fill(rig.played, 60_000)
        while rig.played != rig.ring.head:
            for _ in range(random.between(1, 400)):
                if rig.played != rig.ring.head:
                    word = rig.ring.words[rig.played & rig.ring.mask]
                    rig.played = (rig.played + 1) & 0x1FFFFFFF
                    carriages.follow(rig, [(word >> rig.layout.bits, word & rig.layout.levels_mask)])
            assert told(machine) == carriages.place
        if random.between(0, 5) == 0:
            motors = rig.feeder.position(rig.played)
            planner.stop(motors)
            rig.feeder.cancel(rig.played)
            planner.clear()
            assert list(planner.to_axes(motors)) == carriages.place
            machine.place = list(carriages.place)
    assert told(machine) == carriages.place == machine.place


def check_a_change_of_play(seed):
    """Another play, set at a stand: the position reported stays, and the new play counts from the next turn of each axis on."""
    machine = Played(seed, "lines")
    machine.run()
    before = told(machine)
    machine.um = [machine.random.choice((0, 10, 200)) for _ in range(3)]
    machine.limited(machine.steps_per_m, machine.speeds, machine.accelerations, machine.deviation)
    assert told(machine) == before == machine.place
    machine.program = [(KIND_LINE, (30, -20, 10), 5 * MM), (KIND_LINE, (-30, 20, -10), 5 * MM), (KIND_LINE, (9, 9, 9), 5 * MM)]
    place, machine.facts = machine.place, []
    for move in machine.program:
        machine.add(move)
    machine.rig.run()
    assert told(machine) == [at + 9 for at in place]
