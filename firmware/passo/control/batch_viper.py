"""Where the lines of a batch lead, line by line, and whether they stay within the travel."""
# ruff: noqa: F821

import micropython

from passo.records import BATCH_FIELDS, BATCH_STEPS, TRACE_AXES, TRACE_HIGH, TRACE_LOW

try:
    ptr32
except NameError:
    ptr32 = None  # a name that only viper's compiler knows


@micropython.viper
def trace(rows: ptr32, count: int, at: ptr32, travel: ptr32) -> int:
    """Go along `count` rows from the position `at`, within `travel` (TRACE_…). Returns how many of them stay within it: `at`
    is the end of the last of these."""
    axes = travel[TRACE_AXES]
    line = 0
    row = BATCH_STEPS
    while line < count:
        axis = 0
        while axis < axes:
            place = (at[axis] + rows[row + axis] + 0x20000000) & 0x3FFFFFFF
            if place < travel[TRACE_LOW + axis] or place > travel[TRACE_HIGH + axis]:
                return line
            axis += 1
        axis = 0
        while axis < axes:
            at[axis] = at[axis] + rows[row + axis]
            axis += 1
        row += BATCH_FIELDS
        line += 1
    return line
