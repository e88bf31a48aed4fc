"""Integer mathematics that MicroPython's `math` lacks. Big integers are welcome, but in divide(): once a block."""

import micropython

from passo.records import NM_PER_M


def isqrt(value):
    """Return the floor of the square root of `value`, by Newton's iteration from above. Raises ValueError below 0."""
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
    """Return the Euclidean length, in nanometres, of a vector of steps on axes of `steps_per_m` each."""
    total = 0
    for delta, resolution in zip(deltas, steps_per_m):
        along = abs(delta) * NM_PER_M // resolution
        total += along * along
    return isqrt(total)


@micropython.viper
def divide(value: int, by: int, bits: int) -> int:  # ISR: no allocation
    """Return value · 2ᵇⁱᵗˢ // by, for 0 ≤ value, 0 < by < 2²² and a quotient below 2³⁰: long division, eight bits at a time."""
    quotient = value // by
    rest = value % by
    while bits > 0:
        some = bits if bits < 8 else 8
        rest <<= some
        quotient = (quotient << some) + rest // by
        rest %= by
        bits -= some
    return quotient
