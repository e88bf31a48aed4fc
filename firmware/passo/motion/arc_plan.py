"""The limits of an arc's plan, which arc.plan() works out once a block, and what steps cannot say of an arc: how many turns
it makes. The plan's fields are ARC_… of records.py.
"""

from micropython import const

MAX_RADIUS = const(0x100000)  # 2²⁰ steps
MAX_SLOPE = const(128)  # most steps of the third axis along one step of the circle
LEADS = const(22_938)  # ARC_Z_HIGH from which the third axis dominates somewhere: 0.7 steps a step
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
