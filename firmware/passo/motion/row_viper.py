"""The rows of the planner's queue, as every block fills them in.

    at = enter(rows, work, counts, steps, first)    # the steps of a line go to the next free row, which begins at rows[at]
    through = close(rows, at, work, counts, kind, tag, power, first)    # the row is done, and is counted
    at = take(rows, work, counts, moving, lines)    # the next one released, for the feeder
    power = begun(rows, at, state, tool)            # ... which begins with it

One text for all interpreters: a board compiles it to machine code, elsewhere it is ordinary Python; see measure_viper.py.
The numbers of a row are block.py's, those of `work` profile.py's, of `counts` and the flags of `kind` the planner's, of
`state` those of checkpoints_plain.py.
"""
# ruff: noqa: F821

import micropython

try:
    ptr32
except NameError:
    ptr32 = None  # a name that only viper's compiler knows


@micropython.viper
def enter(rows: ptr32, work: ptr32, counts: ptr32, steps: ptr32, first: int) -> int:
    work[8] = 0
    stride = work[31]
    at = counts[0] % work[32] * stride
    place = at + 25
    end = at + stride
    while place < end:
        rows[place] = steps[first]
        first += 1
        place += 1
    return at


@micropython.viper
def close(rows: ptr32, at: int, work: ptr32, counts: ptr32, kind: int, tag: int, power: int, first: int) -> int:
    """1 where motion goes through to this block from the one before it, at the speed that this one may begin with."""
    rows[at] = kind & 7
    rows[at + 1] = kind >> 3 & 1
    rows[at + 4] = first
    rows[at + 5] = tag
    rows[at + 6] = kind >> 4 & 1
    rows[at + 16] = power
    rows[at + 17] = kind >> 5 & 1
    counts[0] = (counts[0] + 1) & 0x1FFFFFFF  # last: from here on an interrupt may take it
    return work[24]


@micropython.viper
def take(rows: ptr32, work: ptr32, counts: ptr32, moving: int, lines: int) -> int:  # ISR: no allocation
    """Where the next row released begins; -1: there is none, or, `lines`, it is not that of a line with acceleration. A
    machine that is `moving` could not stop here: to it any row is released."""
    fetched = counts[2]
    if fetched == counts[0]:
        return -1
    at = fetched % work[32] * work[31]
    if lines and (rows[at] or rows[at + 9] == 0):
        return -1
    if fetched == counts[1]:
        if ((counts[0] - fetched) & 0x1FFFFFFF) < 64 and moving == 0:
            return -1
        counts[1] = (fetched + 1) & 0x1FFFFFFF
    counts[2] = (fetched + 1) & 0x1FFFFFFF
    return at


@micropython.viper
def begun(rows: ptr32, at: int, state: ptr32, tool: int) -> int:  # ISR: no allocation
    """Where the index of the block begins, and its tool, `tool` being its bit in the levels. Returns its power."""
    state[16] = rows[at + 4]
    levels = state[10] & ~tool
    if rows[at + 1]:
        levels |= tool
    state[10] = levels
    return rows[at + 16]
