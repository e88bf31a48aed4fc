"""Runs on the board, under MicroPython on the PC, and under CPython: the two lines of 2014, timed, alone and at the motors' pace.

    integer_line(0, 0, 5, -3, out)              # step masks of appendix C (Bresenham); bit 0 X, bit 1 Y; returns how many
    float_line(0, 0, 5, -3, out)                # those of appendix G, which truncates, and ends one dominant step short
    time_lines(float_line, points, out)         # (microseconds, steps) of an object
    time_paced(float_line, points, out, 1000)   # microseconds with two waits of so many a step, as the drawing of 2014

Both lines write a mask a step to the same array.
"""

import time

ticks_us = getattr(time, "ticks_us", None) or (lambda: time.perf_counter_ns() // 1000)
ticks_diff = getattr(time, "ticks_diff", None) or (lambda end, begun: end - begun)
sleep_us = getattr(time, "sleep_us", None) or (lambda us: time.sleep(us / 1e6))


def integer_line(x1, y1, x2, y2, out):
    """Write the step masks of a line by Bresenham, appendix C of 2014, to `out`; return how many."""
    dx = abs(x2 - x1)
    dy = abs(y2 - y1)
    if dx >= dy:
        return integer_steps(dx, dy, 1, 2, out)
    return integer_steps(dy, dx, 2, 1, out)


def integer_steps(major, minor, dominant, other, out):
    """Write `major` masks to `out`: a step of the other axis only if the decision is above 0. Return how many."""
    decision = 2 * minor - major
    east = 2 * minor
    north_east = 2 * (minor - major)
    both = dominant | other
    at = 0
    while at < major:
        if decision <= 0:
            decision += east
            out[at] = dominant
        else:
            decision += north_east
            out[at] = both
        at += 1
    return at


def float_line(x1, y1, x2, y2, out):
    """Write the step masks of a line in floating point, appendix G of 2014, to `out`; return how many."""
    if abs(x2 - x1) >= abs(y2 - y1):
        return float_steps(x1, y1, x2, y2, 1, 2, out)
    return float_steps(y1, x1, y2, x2, 2, 1, out)


def float_steps(a0, b0, a1, b1, dominant, other, out):
    """Write a mask a step of axis a: the distance along it times the slope, truncated, is the other axis's position. Return how many."""
    if a0 == a1:
        return 0
    slope = (b1 - b0) / (a1 - a0)
    sign = 1 if a1 > a0 else -1
    before = b0
    at = 0
    for a in range(a0, a1, sign):
        b = int(slope * (a - a0) + b0)
        out[at] = dominant | (other if b != before else 0)
        before = b
        at += 1
    return at


def time_lines(line, points, out):
    """Compute all lines between `points` by `line`; return (microseconds, steps)."""
    begun = ticks_us()
    steps = 0
    for at in range(1, len(points)):
        x1, y1 = points[at - 1]
        x2, y2 = points[at]
        steps += line(x1, y1, x2, y2, out)
    return ticks_diff(ticks_us(), begun), steps


def time_paced(line, points, out, half_us):
    """Return the microseconds of drawing `points` at a pace: compute, wait `half_us` while the clock is low and again while it is high. No step is
    ahead of its time."""
    begun = ticks_us()
    for at in range(1, len(points)):
        x1, y1 = points[at - 1]
        x2, y2 = points[at]
        for _step in range(line(x1, y1, x2, y2, out)):
            sleep_us(half_us)
            sleep_us(half_us)
    return ticks_diff(ticks_us(), begun)
