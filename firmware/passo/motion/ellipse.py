"""Arcs where the plane's axes differ in steps/mm, and helices too steep for the circle's walker: as chords.

    for deltas in chords(deltas, (0, 1, 2), center, steps_per_m):
        planner.line(deltas, …)

In steps such an arc is part of an ellipse. A chord stays within ¼ step of it before its ends are rounded to whole
steps; the third
axis is linear in the swept angle. Big integers, once a chord.
"""

from passo.motion.cordic import TURN, arc_length, rotate, vector
from passo.motion.integers import isqrt


def chords(deltas, plane, center, steps_per_m, clockwise=False, turns=0):
    """Yield the chords' vectors, in steps of all axes; they end at `deltas` exactly. Arguments as of Planner.arc().

    An end in the start's direction is a full turn. Where the end is not on the circle the radius changes evenly.
    Raises ValueError for a radius of 0.
    """
    a, b, third = plane
    wide, high = steps_per_m[b], steps_per_m[a]  # brings both axes to one unit
    x, y = -center[0] * wide, -center[1] * high
    end_x, end_y = (deltas[a] - center[0]) * wide, (deltas[b] - center[1]) * high
    if not (x or y) or not (end_x or end_y):
        raise ValueError("an arc of radius 0")
    start, radius = vector(x, y)
    sweep = (vector(end_x, end_y)[0] - start) % TURN
    if clockwise:
        sweep = TURN - sweep
    if x * end_y == y * end_x and x * end_x + y * end_y > 0:
        sweep = TURN
    sweep += turns * TURN
    if clockwise:
        sweep = -sweep
    # A chord of the angle φ is R·φ² / 8 off, R in steps of the finer axis: ¼ step for φ = √(2 / R).
    steps = radius // min(wide, high) + 1
    angle = arc_length(1 << 20, abs(sweep))
    count = (isqrt(angle * angle * steps // 2) >> 20) + 1
    last_x, last_y = rotate(x, y, sweep)
    before = [0] * len(deltas)
    for i in range(1, count + 1):
        at_x, at_y = rotate(x, y, sweep * i // count)
        at_x += (end_x - last_x) * i // count
        at_y += (end_y - last_y) * i // count
        here = [2 * deltas[axis] * i // count + 1 >> 1 for axis in range(len(deltas))]
        here[a] = center[0] + (2 * at_x + wide) // (2 * wide)
        here[b] = center[1] + (2 * at_y + high) // (2 * high)
        if i == count:
            here = list(deltas)
        yield [here[axis] - before[axis] for axis in range(len(deltas))]
        before = here
