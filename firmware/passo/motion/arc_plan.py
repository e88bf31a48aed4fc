"""Limits of an arc's plan (arc.plan()), and how many turns an arc makes, which its steps alone cannot say. The plan's
fields are ARC_… of records.py.
"""

from micropython import const

MAX_RADIUS = const(0x100000)  # 2²⁰ steps
MAX_SLOPE = const(128)  # most steps of the third axis along one step of the circle
LEADS = const(22_938)  # ARC_Z_HIGH from which the third axis dominates somewhere: 0.7 steps a step
FINE = const(20)  # fraction bits of a length along the circle


def turns_off(cross, dot, over_half):
    """Turns to add (−1, 0 or 1) to the angle between start and end in whole steps, which is above 0 and at most a full turn.

    Rounding to steps may bring the end of a short arc behind its start, which would make it a full turn, and the end of a
    nearly full one before it. `over_half`: the arc as programmed sweeps more than half a turn, full ones aside; None: not
    known. `cross` and `dot`: products of the two radii in steps, the angle's sense positive.
    """
    if dot <= 0 or over_half is None:
        return 0
    if over_half:
        return 1 if cross > 0 else 0
    return 0 if cross > 0 else -1
