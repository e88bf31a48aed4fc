"""The rows of the planner's queue: how they are filled, and how they are taken.

    through = close(rows, at, scratch, indices, kind, flags, tag, power, first)     # the row at rows[at] is done, and is counted
    row = take(rows, scratch, indices, moving, lines)                               # the next one released, for the feeder
    count = room(indices)                                                           # how many more may be added

One text for all interpreters; see block_viper.py. Fields: records.py.
"""
# Shared with interrupts: indices

import micropython

from passo.records import *


@micropython.viper
def room(indices: ptr32) -> int:
    """Return how many more blocks can be queued now; none while it would be one arc too many."""
    added = indices[QUEUE_ADDED]
    queued = (added - indices[QUEUE_RETIRED]) & COUNT_MASK
    if ((added - indices[QUEUE_ARC] - 1) & COUNT_MASK) < queued:
        return 0
    return QUEUE_SIZE - queued


@micropython.viper
def close(rows: ptr32, at: int, scratch: ptr32, indices: ptr32, kind: int, flags: int, tag: int, power: int, first: int) -> int:
    """Finish the row at rows[at], and count it; `flags` as BATCH_FLAGS, the rest as in a row. 1 if motion goes through to
    this block from the one before it, at the speed that this one may begin with."""
    dots = power & ~DOTS_POWER
    if dots:
        power = POWER_MOST
        flags &= ~1
    if flags & 4 and scratch[SCRATCH_THROUGH] and scratch[SCRATCH_LIMITED]:  # power · speed / feed, in binary: it goes beyond 32 bits
        speed = scratch[SCRATCH_SPEED]
        feed = scratch[SCRATCH_FEED]
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
    rows[at + ROW_POWER] = power | dots
    rows[at + ROW_DYNAMIC] = flags >> 2 & 1
    lasts = LONG_TICKS
    if kind == KIND_LINE and rows[at + ROW_TICKS] < 0x4000 and scratch[SCRATCH_STEPS] < 0x4000:
        lasts = rows[at + ROW_TICKS] * scratch[SCRATCH_STEPS]
        if lasts > LONG_TICKS:
            lasts = LONG_TICKS
    rows[at + ROW_LASTS] = lasts
    scratch[SCRATCH_LASTS] = (scratch[SCRATCH_LASTS] + lasts) & 0x1FFFFFFF
    indices[QUEUE_ADDED] = (indices[QUEUE_ADDED] + 1) & 0x1FFFFFFF  # last: from here on an interrupt may take it
    return scratch[SCRATCH_THROUGH]


@micropython.viper
def take(rows: ptr32, scratch: ptr32, indices: ptr32, moving: int, lines: int) -> int:  # ISR: no allocation
    """Take the next row released; returns where it begins, -1 if there is none, or with `lines` if it is no accelerated line.
    If the machine is `moving` it could not stop here: any row is released then; on a live link until all words have been played."""
    fetched = indices[QUEUE_FETCHED]
    if fetched == indices[QUEUE_ADDED]:
        return -1
    at = fetched % scratch[SCRATCH_SIZE] * scratch[SCRATCH_STRIDE]
    if lines and (rows[at + ROW_KIND] or rows[at + ROW_GAIN] == 0):
        return -1
    if fetched == indices[QUEUE_FLUSHED]:
        if ((indices[QUEUE_ADDED] - fetched) & 0x1FFFFFFF) < 64 and moving == 0:
            if scratch[SCRATCH_EAGER] == 0 or fetched == indices[QUEUE_RETIRED]:
                return -1
        indices[QUEUE_FLUSHED] = (fetched + 1) & 0x1FFFFFFF
    scratch[SCRATCH_TAKEN] = (scratch[SCRATCH_TAKEN] + rows[at + ROW_LASTS]) & 0x1FFFFFFF
    indices[QUEUE_FETCHED] = (fetched + 1) & 0x1FFFFFFF
    return at
