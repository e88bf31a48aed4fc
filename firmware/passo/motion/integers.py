"""Integer mathematics that MicroPython's `math` lacks. Big integers are welcome, but in divide(): once a block."""

import micropython

from passo.records import NM_PER_M


def isqrt(value):
    """Floor of the square root of `value` ≥ 0, by Newton's iteration from above."""
    if value < 0:
        raise ValueError("square root of a negative number")
    if value < 2:
        return value
    root = 1
    while root * root < value:
        root <<= 1
    while True:
        better = (root + value // root) >> 1
        if better >= root:
            return root
        root = better


def length_nm(deltas, steps_per_m):
    """Euclidean length, in nanometres, of a vector of steps on axes of `steps_per_m` each."""
    total = 0
    for delta, resolution in zip(deltas, steps_per_m):
        along = abs(delta) * NM_PER_M // resolution
        total += along * along
    return isqrt(total)


@micropython.viper
def divide(value: int, by: int, bits: int) -> int:  # ISR: no allocation
    """value · 2ᵇⁱᵗˢ // by, the quotient below 2³⁰, for 0 < by < 2²²."""
    quotient = value // by
    rest = value % by
    while bits > 0:
        some = bits if bits < 8 else 8
        rest <<= some
        quotient = (quotient << some) + rest // by
        rest %= by
        bits -= some
    return quotient
