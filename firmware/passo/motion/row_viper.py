"""The rows of the planner's queue: how they are filled, and how they are taken.

    through = close(rows, at, work, counts, kind, flags, tag, power, first)     # the row at rows[at] is done, and is counted
    row = take(rows, work, counts, moving, lines)                               # the next one released, for the feeder

One text for all interpreters: a board compiles it to machine code, elsewhere it is ordinary Python; see block_viper.py.
Fields: records.py.
"""
# ruff: noqa: F821

import micropython

from passo.records import (
    QUEUE_ADDED, QUEUE_FETCHED, QUEUE_FLUSHED, ROW_DYNAMIC, ROW_FIRST, ROW_GAIN, ROW_KIND, ROW_POWER, ROW_RAPID,
    ROW_TAG, ROW_TOOL, WORK_FEED, WORK_LIMITED, WORK_SIZE, WORK_SPEED, WORK_STRIDE, WORK_THROUGH,
)  # fmt: skip

try:
    ptr32
except NameError:
    ptr32 = None  # a name that only viper's compiler knows


@micropython.viper
def close(rows: ptr32, at: int, work: ptr32, counts: ptr32, kind: int, flags: int, tag: int, power: int, first: int) -> int:
    """The row at rows[at] is done, and is counted; `flags` as BATCH_FLAGS, the rest as in a row. 1 if motion goes through to
    this block from the one before it, at the speed that this one may begin with."""
    if flags & 4 and work[WORK_THROUGH] and work[WORK_LIMITED]:  # power · speed / feed, in binary: it goes beyond 32 bits
        speed = work[WORK_SPEED]
        feed = work[WORK_FEED]
        rest = 0
        level = 0
        bit = 512
        while bit:
            rest <<= 1
            level <<= 1
            if power & bit:
                rest += speed
            while rest >= feed:
                rest -= feed
                level += 1
            bit >>= 1
        power = level
    rows[at + ROW_KIND] = kind
    rows[at + ROW_TOOL] = flags & 1
    rows[at + ROW_FIRST] = first
    rows[at + ROW_TAG] = tag
    rows[at + ROW_RAPID] = flags >> 1 & 1
    rows[at + ROW_POWER] = power
    rows[at + ROW_DYNAMIC] = flags >> 2 & 1
    counts[QUEUE_ADDED] = (counts[QUEUE_ADDED] + 1) & 0x1FFFFFFF  # last: from here on an interrupt may take it
    return work[WORK_THROUGH]


@micropython.viper
def take(rows: ptr32, work: ptr32, counts: ptr32, moving: int, lines: int) -> int:  # ISR: no allocation
    """Take the next row released; returns where it begins, -1 if there is none, or with `lines` if it is no accelerated line.
    If the machine is `moving` it could not stop here: any row is released then."""
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
