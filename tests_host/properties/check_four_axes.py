"""Four axes, the last a slide or one that turns (its mm are degrees): ends to the step, the limits of each, arcs while it stands."""

import check_motion
from passo.records import KIND_ARC
from random_motion import MM, Machine

CASES = {"check_limits": (("seed", "seed"), ("kind", "choice", "mixed", "lines", "tiny", "reversals", "arcs"))}
RUNS = {"check_limits": 30}
EXAMPLES = {"check_limits": ((1514, "arcs"),)}  # helices of 2 to 4 steps of the circle and 260 of the third axis


class Four(Machine):
    """A machine of random_motion.py with a fourth axis: it moves with the others, alone, or not at all."""

    axes = 4

    def limited(self, steps_per_m, speeds, accelerations, deviation, start=0):
        random = self.random
        steps_per_m = steps_per_m + [random.choice((53_333, 80_000, 400_000))]
        speeds, accelerations = speeds + [random.between(5, 400) * MM], accelerations + [random.between(50, 3000) * MM]
        Machine.limited(self, steps_per_m, speeds, accelerations, deviation, start)

    def _draw(self, kind):
        random = self.random
        before = len(self.program)
        Machine._draw(self, kind)
        size = random.choice((2, 30, 500, 2500)) // max(len(self.program) - before, 1)
        alone = random.between(0, 3) == 0
        for number in range(before, len(self.program)):
            move = self.program[number]
            if move[0] == KIND_ARC:
                ways = move[1] + (0,)
            else:
                by = random.choice((0, random.between(-size, size), size if number % 2 else -size))
                ways = (0, 0, 0, by) if alone else move[1] + (by,)
            self.program[number] = (move[0], ways) + move[2:]

    def _tangent(self, move, place, flat, rise):
        return Machine._tangent(self, move, place, flat, rise) + [0]


def check_limits(seed, kind):
    hold_limits(seed, kind)


def hold_limits(seed, kind):
    return check_motion.hold_limits(seed, kind, Four)
