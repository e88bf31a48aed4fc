"""Every radius from 1 to 2000, whole circles and random helices, and random radii to 2²⁰.

    python tests_host/properties/soak_circle.py 1 2000        # every radius from 1 to 2000; under MicroPython too

Prints every arc that fails, and last, for all: arcs, words, how far they are off the ideal circle at most, in steps, the third axis off linear as a part of its
limit, the end point by CORDIC off the true one, and how many failed.
"""

import sys

from check_circle import about, draw_arc, hold_arc
from check_cordic import distance
from draws import Random
from passo.motion.cordic import TURN

LARGE_STEPS = 3000  # of an arc on a large radius


def arcs_of(radius, random):
    """A whole circle, an arc, a helix, and a short arc on a radius of any size."""
    start = about(radius, random.between(0, 6283) / 1000)
    yield (0, 1, 2), (-start[0], -start[1]), (0, 0, 0), random.choice((False, True)), 0
    yield draw_arc(radius, random.between(0, 1 << 29))
    yield draw_arc(radius, random.between(0, 1 << 29), random.between(-radius, radius) // 2)
    large = 1 << random.between(4, 20)
    yield draw_arc(random.between(large >> 1, large), random.between(0, 1 << 29), longest=LARGE_STEPS)


def soak(first, last):
    arcs = words = failed = 0
    farthest = lag = end = 0.0
    for radius in range(first, last + 1):
        random = Random(radius)
        for arc in arcs_of(radius, random):
            try:
                figures = hold_arc(arc)
            except AssertionError as error:
                print("FAILED", arc, error)
                failed += 1
                continue
            arcs += 1
            words += figures[0]
            farthest = max(farthest, figures[1])
            lag = max(lag, figures[2])
        for _ in range(50):
            size = 1 << random.between(1, 20)
            x, y = random.between(-size, size), random.between(-size, size)
            end = max(end, distance(x, y, random.between(-4 * TURN, 4 * TURN)))
    print(arcs, words, "%.3f %.3f %.3f" % (farthest, lag, end), failed)
    return failed


if __name__ == "__main__":
    sys.exit(1 if soak(int(sys.argv[1]), int(sys.argv[2])) else 0)
