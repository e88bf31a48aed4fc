"""The plan of an arc: what arc.plan() works out, once a block, for the circle's walker. An array of small integers.

And what steps cannot say of an arc: how many turns it makes.
"""

from micropython import const

PLAN = const(21)  # its size
AXIS_A, AXIS_B, AXIS_Z, MIRROR, REGION, U, W = 0, 1, 2, 3, 4, 5, 6
RADIUS, SHIFT, D, E, STEPS, DIAGONAL = 7, 8, 9, 10, 11, 12
Z_STEPS, Z_HIGH, Z_LOW, TAIL_A, TAIL_B, TAIL_Z, PATH = 13, 14, 15, 16, 17, 18, 19
PATH_FINE = 20

MAX_RADIUS = const(0x100000)  # 2²⁰ steps
MAX_SLOPE = const(128)  # most steps of the third axis along one step of the circle
LEADS = const(22_938)  # Z_HIGH from which the third axis dominates somewhere: 0.7 steps a step
FINE = const(20)  # fraction bits of a length along the circle


def turns_off(cross, dot, over_half):
    """How many turns are to be added to the angle from an arc's start to its end as whole steps have it, which is above 0 and
    up to a full turn: −1, 0 or 1.

    `cross` and `dot`: products of the two radii in steps, the angle's sense positive. `over_half`: the arc as it was asked
    for, before anything was rounded, sweeps more than half a turn, full ones aside; None: nobody knows. Rounding may bring
    the end of a short arc behind its start, which would be a full turn, and the end of a nearly full one before it.
    """
    if dot <= 0 or over_half is None:
        return 0
    if over_half:
        return 1 if cross > 0 else 0
    return 0 if cross > 0 else -1
