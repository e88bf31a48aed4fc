"""The interlock's arithmetic: the bits that the inputs forbid, and the steps that lie ahead.

    forbidden = find_denied(table, states)          # mask of INTERLOCK_…; `states`: a bit an input, 1: active
    if find_ahead(state, marks, played, forbidden): …   # what is made and not yet played steps so, or has the tool on

A table is what manifest_table.py makes. Called in interrupts: both allocate nothing. On an RP2040 find_denied()
takes about 0.5 µs a product, find_ahead() about 3 µs a segment until it finds something: 40 µs if that is nothing.

A segment counts with the whole of its way, so of an arc that turns round within one segment (6 ms at most) only the net
direction is seen until the next.

One text for all interpreters; see motion/block_viper.py.
"""

# Shared with interrupts: state, marks
import micropython
from micropython import const

from passo.records import *

# The interlock's masks: a bit for each direction of an axis (2 · axis forward, the next back: 8 bits), then:
INTERLOCK_TOOL = const(0x100)
INTERLOCK_OUTPUTS = const(0x200)  # the first of the board file's outputs

# A table of the interlock, made by manifest_table.py: these, then PERMIT_FIELDS numbers a product.
PERMIT_PRODUCTS = const(0)  # how many
PERMIT_GATED = const(1)  # mask of all that the table is about, INTERLOCK_…
PERMIT_FIRST = const(2)
PERMIT_CARE = const(0)  # of a product: the inputs that it looks at, a bit each
PERMIT_VALUE = const(1)  # how these must be
PERMIT_ALLOWS = const(2)  # the bits that it then allows
PERMIT_FIELDS = const(3)


@micropython.viper
def find_denied(table: ptr32, states: int) -> int:  # ISR: no allocation
    """Return the mask of bits that are gated and not allowed."""
    left = table[PERMIT_PRODUCTS]
    result = table[PERMIT_GATED]
    at = PERMIT_FIRST
    while left:
        if states & table[at + PERMIT_CARE] == table[at + PERMIT_VALUE]:
            result &= ~table[at + PERMIT_ALLOWS]
        at += PERMIT_FIELDS
        left -= 1
    return result


@micropython.viper
def find_ahead(state: ptr32, marks: ptr32, played: int, wanted: int) -> int:  # ISR: no allocation
    """The first of the `wanted` directions found in segments not yet played to their end: mask, bit 2 · axis forward, the next
    back; INTERLOCK_TOOL if it is wanted and the last segment made has the tool on. 0: there is none."""
    stride = MARK_FIELDS + state[FEED_AXES]
    number = state[FEED_OLDEST]
    if wanted & INTERLOCK_TOOL and state[FEED_LEVELS] & state[FEED_TOOL]:
        return INTERLOCK_TOOL
    while number != state[FEED_NEWEST]:
        before = (number & (MARKS - 1)) * stride
        number = (number + 1) & COUNT_MASK
        at = (number & (MARKS - 1)) * stride
        if ((played - marks[at + MARK_WORD]) & COUNT_MASK) >= COUNT_HALF:
            axis = stride - MARK_FIELDS
            while axis:
                axis -= 1
                by = (marks[at + MARK_FIELDS + axis] - marks[before + MARK_FIELDS + axis]) & COUNT_MASK
                if by and wanted >> (axis << 1) & (1 if by < COUNT_HALF else 2):
                    return (1 if by < COUNT_HALF else 2) << (axis << 1)
    return 0
