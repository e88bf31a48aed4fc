"""The ramp's arithmetic: ticks of a path, what a change of speed costs, a root. No integer reaches 2³⁰; all may run in an
interrupt. Speeds are in the block's units (see profile.py), with V_BITS fraction bits."""

from micropython import const

from passo.motion.integers import divide

FAR = const(0x1FFFFFFF)  # 2²⁹ − 1: the most q a segment may gain
V_BITS = const(7)  # fraction bits of a speed; with them it has 22 at most


def path_ticks(path, each, part):  # ISR: no allocation
    """Ticks of `path` (2⁻¹⁷ steps) at each + part / 128 a step."""
    whole = path >> 17
    fraction = path & 0x1FFFF
    if each < 0x80000:
        ticks = (whole * part >> 7) + (fraction * part >> 24)
        ticks += ((fraction >> 7) * each >> 10) + ((fraction & 127) * each >> 17)
    elif each < 0x800000:
        ticks = fraction * (each >> 10) >> 7
    else:
        ticks = (fraction >> 7) * (each >> 10)
    return (whole * each + ticks) or 1


def gained(gain, steps, part):  # ISR: no allocation
    """gain · (steps + part / 2¹⁷)."""
    if not part:
        return steps * gain
    return steps * gain + (gain >> 17) * part + (((gain & 0x1FFFF) >> 5) * part >> 12)


def root_of(q, near):  # ISR: no allocation
    """√q with V_BITS fraction bits; quick where `near`, a speed, is near it."""
    if q < 1:
        return 0
    root = near >> V_BITS or 0x2000
    better = (root + q // root) >> 1
    while better > root + 1 or better < root - 1:
        root = better
        better = (root + q // root) >> 1
    root = better
    while root * root > q:
        root -= 1
    return (root << V_BITS) + ((q - root * root) << V_BITS - 1) // root


def loss(block, fast, change):  # ISR: no allocation
    """Ticks that a change of speed up to `fast` costs, against having that speed all along: t · change / 2·fast.

    Rounded up: never more acceleration than allowed.
    """
    ratio = divide(change, fast, 14)  # ≤ 2¹⁴
    shift = block.time_shift + V_BITS
    while change >= 0x8000:
        change >>= 1
        shift -= 1
    ticks = change * block.time  # 15 bits by 15
    if shift >= 0:
        ticks >>= shift
    else:
        ticks = ticks << -shift if ticks < FAR >> -shift else FAR
    if ticks < 0x8000:
        return (ticks * ratio >> 15) + 1
    return (ticks >> 15) * ratio + ((ticks & 0x7FFF) * ratio >> 15) + 1
