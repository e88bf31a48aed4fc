"""Bipolar motors by two PBL3770A chips, one a winding. Six pins a motor, lowest first: PH I0 I1 of A, PH I0 I1 of B.

PH is the winding's direction; I0 and I1 choose its current: both low 100 %, I0 high 60 %, I1 high 20 %, both high none.
Full step keeps both windings at 60 % and toggles one PH a step, so that a reversal changes one phase only. Half step
has one winding off between two full steps; the winding that is then alone gets 100 %, to keep the torque even.
"""

WIDTH = 6
PINS = ("ph_a", "i0_a", "i1_a", "ph_b", "i0_b", "i1_b")

FULL_CURRENT = 0b000
PART_CURRENT = 0b010  # 60 %
HOLD_CURRENT = 0b100  # 20 %
NO_CURRENT = 0b110
_FORWARD = 0b001  # PH

# Windings of the eight half steps: direction of A and of B; 0 is off. A full step is every state with both on.
_HALF_STEPS = ((1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1))


def _winding(direction, current):
    if not direction:
        return NO_CURRENT
    return current | (_FORWARD if direction > 0 else 0)


def _table(states, alone, both):
    table = []
    for a, b in states:
        current = both if a and b else alone
        table.append(_winding(a, current) | _winding(b, current) << 3)
    return bytes(table)


_FULL_STEPS = tuple([state for state in _HALF_STEPS if state[0] and state[1]])

HALF = _table(_HALF_STEPS, FULL_CURRENT, PART_CURRENT)
FULL = _table(_FULL_STEPS, PART_CURRENT, PART_CURRENT)
MODES = {"half": HALF, "full": FULL}
HOLD = {
    "half": _table(_HALF_STEPS, HOLD_CURRENT, HOLD_CURRENT),
    "full": _table(_FULL_STEPS, HOLD_CURRENT, HOLD_CURRENT),
}
OFF = NO_CURRENT | NO_CURRENT << 3
