"""The ramp's arithmetic, where jerk is limited: ticks of a path, what q gains along it, a root. No integer reaches 2³⁰; all
may run in an interrupt. Speeds are in the block's units (see profile.py), with V_BITS fraction bits."""

from micropython import const

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
