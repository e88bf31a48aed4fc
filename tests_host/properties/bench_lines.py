"""The comparison of 2014 again: integer lines against floating-point lines, on the same five kinds of object.

    MICROPYPATH=build/unix/STATE:tests_host/properties:tests_host/sims:host_tools/experiments:. micropython tests_host/properties/bench_lines.py < objects.txt

Each line of the input is `name x y x y …`, the corners in steps. For each object it prints its name, points and steps,
and the best of REPEATS times, in microseconds, to make the step masks of all its lines: with the integer line as it
drives the machine here (machine code where the interpreter has any), with its plain twin, and with the document's
floating-point line (appendix G), which truncates, and stops one dominant step short of every end. All write one mask a
step to the same array; the last two are interpreted alike, so that is the comparison of 2014.
"""

import sys
import time
from array import array

from passo.motion import line as lines
from passo.motion import line_viper
from board_lines import float_line
from plain import plain
from passo.motion.line import MAX_RUN, Line

REPEATS = 7
OUT = array("I", bytearray(4 * MAX_RUN))


def integer(points):
    line = Line(2)
    steps = 0
    for (x0, y0), (x1, y1) in zip(points, points[1:]):
        line.begin((x1 - x0, y1 - y0))
        while line.left:
            run = min(line.left, MAX_RUN)
            line.walk(OUT, 0, run)
            steps += run
    return steps


def floating(points):
    return sum(float_line(*begin, *end, OUT) for begin, end in zip(points, points[1:]))


def best_us(function, points):
    """Return the shortest of REPEATS runs, in microseconds, and the function's value."""
    ticks_us = getattr(time, "ticks_us", None) or (lambda: time.perf_counter_ns() // 1000)
    shortest = None
    for _ in range(REPEATS):
        begun = ticks_us()
        result = function(points)
        spent = ticks_us() - begun
        shortest = spent if shortest is None else min(shortest, spent)
    return shortest, result


def main():
    for text in sys.stdin:
        name, *numbers = text.split()
        numbers = [int(number) for number in numbers]
        points = list(zip(numbers[::2], numbers[1::2]))
        driven_us, steps = best_us(integer, points)
        driven_walk = lines.walk
        lines.walk = plain(line_viper)["walk"]
        plain_us, _ = best_us(integer, points)
        lines.walk = driven_walk
        float_us, _ = best_us(floating, points)
        print(name, len(points), steps, driven_us, plain_us, float_us)


if __name__ == "__main__":
    main()
