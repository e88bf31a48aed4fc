"""Bipolar motors by two PBL3770A chips, one a winding. Six pins a motor, lowest first: PH I0 I1 of A, PH I0 I1 of B.

PH is the winding's direction; I0 and I1 choose its current: both low 100 %, I0 high 60 %, I1 high 20 %, both high none.
Full step keeps both windings at 60 % and toggles one PH a step, so that a reversal changes one phase only. Half step
has one winding off between two full steps; the winding that is then alone gets 100 %, to keep the torque even.

Microsteps take the pair of currents whose direction comes nearest; torque follows the length of their sum:

    eighth of a full step     0      1      2      3      4      5      6      7
    A, B in percent        100 0  100 20  60 20 100 60  60 60 60 100  20 60 20 100
    off, electrical degrees   0     0.1   -4.1   -2.8     0     2.8    4.1   -0.1
    torque, percent          100    102     63    117     85    117     63    102

A motor of 1.8° is off by 0.08° at most. At rest a winding pair has the least currents of the same direction; between half
steps these are those that it moves with.
"""

from passo.options.coil_drives.drive import of_board

PINS = ("ph_a", "i0_a", "i1_a", "ph_b", "i0_b", "i1_b")

FULL_CURRENT = 0b000
PART_CURRENT = 0b010  # 60 %
HOLD_CURRENT = 0b100  # 20 %
NO_CURRENT = 0b110
_FORWARD = 0b001  # PH

# Currents of A and B in the eighths of a full step.
_QUARTER = (
    (FULL_CURRENT, NO_CURRENT), (FULL_CURRENT, HOLD_CURRENT), (PART_CURRENT, HOLD_CURRENT), (FULL_CURRENT, PART_CURRENT),
    (PART_CURRENT, PART_CURRENT), (PART_CURRENT, FULL_CURRENT), (HOLD_CURRENT, PART_CURRENT), (HOLD_CURRENT, FULL_CURRENT),
)  # fmt: skip
_AT_REST = ((HOLD_CURRENT, NO_CURRENT),) + _QUARTER[1:4] + ((HOLD_CURRENT, HOLD_CURRENT),) + _QUARTER[5:]
_STEPS = {"full": (8, 4), "half": (4, 0), "quarter": (2, 0), "eighth": (1, 0)}  # eighths of a full step, and the first one


def _winding_levels(current, forward):
    """Return the three levels of a winding: PH, I0, I1. Without current PH stays low."""
    return current | _FORWARD if forward and current != NO_CURRENT else current


def _phase_table(quarter, step, first):
    """Return the levels of an electrical turn, a byte a phase. Each quarter turns the one before it by 90°: A and B become −B and A."""
    table = []
    for eighth in range(first, 32, step):
        a, b = quarter[eighth & 7]
        turned = eighth >> 3
        if turned & 1:
            a, b = b, a
        table.append(_winding_levels(a, turned in (0, 3)) | _winding_levels(b, turned < 2) << 3)
    return bytes(table)


MODES = {mode: _phase_table(_QUARTER, *_STEPS[mode]) for mode in _STEPS}
HOLD = {mode: _phase_table(_AT_REST, *_STEPS[mode]) for mode in _STEPS}
OFF = NO_CURRENT | NO_CURRENT << 3


def create(board):
    """Return the CoilDrive of a checked board."""
    mode = board["drive"]["mode"]
    return of_board(board, PINS, MODES[mode], OFF, HOLD[mode])
