"""Integers brought to a length, divided and rooted: the arithmetic that the kernels share.

    shift = lift(value, 0x4000) - drop(value, 0x8000)      # short float: value = scale(value, shift), of 15 bits

One text for all interpreters; block_viper.py says what that asks of integers. `int()` around a call tells viper its type.
"""

import micropython
from micropython import const

from passo.records import INT_MOST

INT_HALF = const(0x20000000)  # ((number + INT_HALF) & INT_MOST) − INT_HALF reads a negative one on every interpreter


@micropython.viper
def size(value: int) -> int:  # ISR: no allocation
    """Return |value|, which is below 2³⁰. Bit 30 tells the sign: where viper is 64 bits wide it reads a negative number as a positive one."""
    if value >> 30 & 1:
        value = 0 - value
    return value & 0x3FFFFFFF


@micropython.viper
def sign_extend(number: int) -> int:  # ISR: no allocation
    """Return a number within ±2²⁹ that has been read out of an array: where viper is 64 bits wide it reads a negative one as positive."""
    return ((number + INT_HALF) & INT_MOST) - INT_HALF


@micropython.viper
def lift(value: int, least: int) -> int:  # ISR: no allocation
    """Return how often `value` > 0 has to be doubled to reach `least`."""
    shift = 0
    while value < least:
        value <<= 1
        shift += 1
    return shift


@micropython.viper
def drop(value: int, most: int) -> int:  # ISR: no allocation
    """Return how often `value` ≥ 0 has to be halved to fall below `most` > 0."""
    shift = 0
    while value >= most:
        value >>= 1
        shift += 1
    return shift


@micropython.viper
def scale(value: int, shift: int) -> int:  # ISR: no allocation
    """Return value · 2^shift, rounded down; the product is below 2³¹."""
    if shift >= 0:
        return value << shift
    if shift < 0 - 31:
        return 0
    return value >> (0 - shift)


@micropython.viper
def scale_clamped(value: int, shift: int) -> int:  # ISR: no allocation
    """Return value · 2^shift, rounded down, at most 2²⁹ − 1; 0 ≤ value < 2³¹."""
    if shift > 0 and value:
        room = int(lift(value, 0x10000000)) if value < 0x10000000 else 0
        if shift > room:
            return 0x1FFFFFFF
    value = int(scale(value, shift)) if value else 0
    return value if value < 0x1FFFFFFF else 0x1FFFFFFF


@micropython.viper
def quotient(value: int, by: int) -> int:  # ISR: no allocation
    """Return value · 2¹⁴ / by to 10⁻⁷, by long division in two steps: by ≥ 2²⁶, value below 2²⁹, the quotient below 2³¹."""
    high = by >> 14
    first = value // high
    rest = ((value % high) << 14) - first * (by & 0x3FFF)
    return (first << 14) + rest // high


@micropython.viper
def root(square: int) -> int:  # ISR: no allocation
    """Return the floor of the square root of 0 ≤ square < 2³⁰, bit by bit: an RP2040 divides no faster."""
    found = 0
    bit = 0x4000
    while bit:
        if (found + bit) * (found + bit) <= square:
            found += bit
        bit >>= 1
    return found
