"""Speeds in a block's units, and the ticks that they take: shared by ramps and S-curves.

    q = q_of(square, rows, at, limit)       # a square of speed of 2²⁸, in the units of the block whose row begins at rows[at]
    speed = root_of(q, near)                # units, with 7 fraction bits
    ticks = path_ticks(path, span, speed)   # how long a path lasts
    nm_s = along(rows, at, pace, whole)     # the pace of a segment (RAMP_PACE) as a speed
    progress(rows, seen)                    # line and speed of what is under way, for a status report

A path is whole steps · 2¹⁷. One text for all interpreters; block_viper.py says what that asks of integers. None reaches 2³⁰.
"""

import micropython

from passo.motion.scale_viper import sign_extend
from passo.records import *


@micropython.viper
def q_of(square: int, rows: ptr32, at: int, limit: int) -> int:  # ISR: no allocation
    """q of the square of a speed, in a block's units; `limit` squared at most."""
    unit = rows[at + ROW_UNIT]
    shift = int(sign_extend(rows[at + ROW_UNIT_SHIFT])) - 14
    q = (square >> 14) * unit + ((square & 0x3FFF) * unit >> 14)
    most = limit * limit
    if shift < 0:
        if q >= most >> (0 - shift):
            return most
        return q << (0 - shift)
    q >>= shift
    return q if q < most else most


@micropython.viper
def root_of(q: int, near: int) -> int:  # ISR: no allocation
    """√q with 7 fraction bits; quick where `near`, a speed, is near it."""
    if q < 1:
        return 0
    root = near >> 7 if near > 127 else 0x2000
    better = (root + q // root) >> 1
    while better > root + 1 or better < root - 1:
        root = better
        better = (root + q // root) >> 1
    while better * better > q:
        better -= 1
    return (better << 7) + ((q - better * better) << 6) // better


@micropython.viper
def step_ticks(span: int, speed: int) -> int:  # ISR: no allocation
    """Return the ticks of a step at `speed`, in units of the block: span · 64 / speed."""
    whole = span // speed
    return (whole << 6 if whole < 0x800000 else 0x1FFFFFFF) + ((span - whole * speed) << 6) // speed


@micropython.viper
def path_ticks(path: int, span: int, speed: int) -> int:  # ISR: no allocation
    """Return the ticks of a path (2⁻¹⁷ steps) at a mean `speed` ≥ 1; 1 at least."""
    whole = span // speed
    rest = (span - whole * speed) << 6
    each = rest // speed
    rest = ((rest - each * speed) << 7) // speed
    return int(spread(path, (whole << 6 if whole < 0x800000 else 0x1FFFFFFF) + each, rest))


@micropython.viper
def spread(path: int, each: int, rest: int) -> int:  # ISR: no allocation
    """Return the ticks of a path whose steps take each + rest / 2⁷ ticks; 1 at least. If a step is longer than 2¹⁹ ticks, `rest` is left out. All
    bits of `path` count: a word of a steep helix may take less than a hundredth of a step of its circle.
    """
    whole = path >> 17
    path &= 0x1FFFF
    ticks = whole * each
    if each < 0x80000:
        ticks += (whole * rest >> 7) + (path * rest >> 24) + ((path >> 7) * each >> 10) + ((path & 127) * each >> 17)
    else:
        high = each >> 10
        ticks += (path >> 7) * high + ((path & 127) * high >> 7) + ((path >> 7) * (each & 0x3FF) >> 10)
    return ticks if ticks else 1


@micropython.viper
def q_change(gain: int, steps: int, part: int) -> int:  # ISR: no allocation
    """Return the change of q along steps + part / 2¹⁷ steps of path: gain · (steps + part / 2¹⁷)."""
    return steps * gain + (gain >> 17) * part + (((gain & 0x1FFFF) >> 5) * part >> 12)


@micropython.viper
def along(rows: ptr32, at: int, pace: int, whole: int) -> int:
    """Return the speed along the path at `pace`, which counts in units of the block at rows[at]. ROW_SPEED is a fraction, of 2²⁸, of `whole`, the
    machine's fastest speed (below 2³⁰, in nm/s or a multiple of it). The product is formed from halves of 14 and 15 bits: no sum
    reaches 2³¹."""
    part = rows[at + ROW_SPEED]
    high = part >> 14
    low = part & 0x3FFF
    asked = high * (whole & 0x7FFF) + (low * (whole >> 15) << 1) + (low * (whole & 0x7FFF) >> 14)
    asked = (high * (whole >> 15) << 1) + (asked >> 14)
    if rows[at + ROW_GAIN] == 0:
        return asked
    top = rows[at + ROW_TOP]
    return asked // top * pace + asked % top * pace // top


@micropython.viper
def progress(rows: ptr32, seen: ptr32):
    """SEEN_LINE and the speed of the block at SEEN_ROW, by SEEN_PACE and SEEN_FASTEST; no speed if the machine has no limits."""
    seen[SEEN_LINE] = 0
    speed = 0
    at = int(sign_extend(seen[SEEN_ROW]))
    if at >= 0 and rows[at + ROW_KIND] != KIND_WAIT:
        seen[SEEN_LINE] = rows[at + ROW_TAG]
        pace = seen[SEEN_PACE]
        if pace and seen[SEEN_FASTEST]:
            speed = int(along(rows, at, pace, seen[SEEN_FASTEST]))
    shift = seen[SEEN_SHIFT]
    seen[SEEN_MM_S] = speed // (1_000_000 >> shift)
    seen[SEEN_NM_S] = speed % (1_000_000 >> shift) << shift
