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

from passo.records import (
    FEED_INDEX, FEED_LEVELS, QUEUE_ADDED, QUEUE_FETCHED, QUEUE_FLUSHED, ROW_DYNAMIC, ROW_FIRST, ROW_GAIN, ROW_KIND, ROW_POWER,
    ROW_RAPID, ROW_STEPS, ROW_TAG, ROW_TOOL, WORK_IS_ARC, WORK_SIZE, WORK_STRIDE, WORK_THROUGH,
)  # fmt: skip

try:
    ptr32
except NameError:
    ptr32 = None  # a name that only viper's compiler knows


@micropython.viper
def enter(rows: ptr32, work: ptr32, counts: ptr32, steps: ptr32, first: int) -> int:
    work[WORK_IS_ARC] = 0
    stride = work[WORK_STRIDE]
    at = counts[QUEUE_ADDED] % work[WORK_SIZE] * stride
    place = at + ROW_STEPS
    end = at + stride
    while place < end:
        rows[place] = steps[first]
        first += 1
        place += 1
    return at


@micropython.viper
def close(rows: ptr32, at: int, work: ptr32, counts: ptr32, kind: int, tag: int, power: int, first: int) -> int:
    """1 where motion goes through to this block from the one before it, at the speed that this one may begin with."""
    rows[at + ROW_KIND] = kind & 7
    rows[at + ROW_TOOL] = kind >> 3 & 1
    rows[at + ROW_FIRST] = first
    rows[at + ROW_TAG] = tag
    rows[at + ROW_RAPID] = kind >> 4 & 1
    rows[at + ROW_POWER] = power
    rows[at + ROW_DYNAMIC] = kind >> 5 & 1
    counts[QUEUE_ADDED] = (counts[QUEUE_ADDED] + 1) & 0x1FFFFFFF  # last: from here on an interrupt may take it
    return work[WORK_THROUGH]


@micropython.viper
def take(rows: ptr32, work: ptr32, counts: ptr32, moving: int, lines: int) -> int:  # ISR: no allocation
    """Where the next row released begins; -1: there is none, or, `lines`, it is not that of a line with acceleration. A
    machine that is `moving` could not stop here: to it any row is released."""
    fetched = counts[QUEUE_FETCHED]
    if fetched == counts[QUEUE_ADDED]:
        return -1
    at = fetched % work[WORK_SIZE] * work[WORK_STRIDE]
    if lines and (rows[at + ROW_KIND] or rows[at + ROW_GAIN] == 0):
        return -1
    if fetched == counts[QUEUE_FLUSHED]:
        if ((counts[QUEUE_ADDED] - fetched) & 0x1FFFFFFF) < 64 and moving == 0:
            return -1
        counts[QUEUE_FLUSHED] = (fetched + 1) & 0x1FFFFFFF
    counts[QUEUE_FETCHED] = (fetched + 1) & 0x1FFFFFFF
    return at


@micropython.viper
def begun(rows: ptr32, at: int, state: ptr32, tool: int) -> int:  # ISR: no allocation
    """Where the index of the block begins, and its tool, `tool` being its bit in the levels. Returns its power."""
    state[FEED_INDEX] = rows[at + ROW_FIRST]
    levels = state[FEED_LEVELS] & ~tool
    if rows[at + ROW_TOOL]:
        levels |= tool
    state[FEED_LEVELS] = levels
    return rows[at + ROW_POWER]
