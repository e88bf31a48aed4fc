"""A line's vector of steps: its dominant axis, its length, its direction, and the axes' limits along it.

    total = most_steps(rows, at + ROW_STEPS, axes)
    measure(rows, at + ROW_STEPS, scratch, limits)      # SCRATCH_HEADING, _LENGTH, _ALONG and _STRENGTH of the line

One text for all interpreters; block_viper.py says what that asks of integers.
"""

import micropython

from passo.motion.scale_viper import lift, quotient, root, scale, size
from passo.records import *


@micropython.viper
def most_steps(rows: ptr32, at: int, axes: int) -> int:
    """Return the steps of the axis that has the most, of the vector rows[at : at + axes]."""
    most = 0
    i = 0
    while i < axes:
        steps = int(size(rows[at + i]))
        if steps > most:
            most = steps
        i += 1
    return most


@micropython.viper
def measure(rows: ptr32, at: int, scratch: ptr32, limits: ptr32):
    """Direction (of 2²⁸, one number an axis), length, and the highest speed and acceleration that the axes allow along the
    vector rows[at:], whose dominant steps, SCRATCH_STEPS, are known."""
    axes = limits[LIMIT_AXES]
    shift = int(set_lengths(rows, at, scratch, limits))
    length = int(norm(scratch, axes))
    scratch[SCRATCH_LENGTH] = length
    scratch[SCRATCH_LENGTH_SHIFT] = limits[LIMIT_FINEST] + shift  # nanometres are length / 2 ** (this − 1000)
    scratch[SCRATCH_ALONG] = 0x20000000
    scratch[SCRATCH_STRENGTH] = 0x20000000
    i = 0
    while i < axes:
        along = scratch[SCRATCH_HEADING + i]
        if along:
            along = int(quotient(along, length))
            allow(scratch, limits, i, along)
            if rows[at + i] >> 30 & 1:
                along = 0 - along
        scratch[SCRATCH_HEADING + i] = along
        i += 1


@micropython.viper
def set_lengths(rows: ptr32, at: int, scratch: ptr32, limits: ptr32) -> int:
    """Write how far each axis goes to SCRATCH_HEADING, all in one unit in which the farthest has 27 bits. Returns the
    exponent of that unit, over LIMIT_FINEST."""
    total = scratch[SCRATCH_STEPS]
    axes = limits[LIMIT_AXES]
    shift = 0
    while total < 4096:
        total <<= 1
        shift += 1
    while total >= 8192:
        total >>= 1
        shift -= 1
    most = 0
    i = 0
    while i < axes:
        along = int(length_of(int(size(rows[at + i])), limits[LIMIT_STEP + i], shift))
        scratch[SCRATCH_HEADING + i] = along
        if along > most:
            most = along
        i += 1
    more = int(lift(most, 0x4000000))
    i = 0
    while i < axes:
        scratch[SCRATCH_HEADING + i] = scratch[SCRATCH_HEADING + i] << more
        i += 1
    return shift + more


@micropython.viper
def length_of(steps: int, step: int, shift: int) -> int:
    """steps · step · 2^(shift − 14), rounded down in each of its digits of 14 bits; steps · 2^shift below 2¹³."""
    high = step >> 14
    along = 0
    if shift >= 0:
        steps <<= shift
    else:
        along = (steps & ((1 << (0 - shift)) - 1)) * high >> (0 - shift)
        steps >>= 0 - shift
    return along + steps * high + (steps * (step & 0x3FFF) >> 14)


@micropython.viper
def norm(scratch: ptr32, axes: int) -> int:
    """Length of the vector at SCRATCH_HEADING: the root of the squares' sum, in digits of 14 bits, a² = aₕ²·2²⁸ + 2aₕaₗ·2¹⁴ + aₗ²."""
    square = 0
    middle = 0
    low = 0
    i = 0
    while i < axes:
        high = scratch[SCRATCH_HEADING + i] >> 14
        rest = scratch[SCRATCH_HEADING + i] & 0x3FFF
        square += high * high
        middle += high * rest
        low += rest * rest >> 14
        i += 1
    square += middle >> 13
    low += (middle & 0x1FFF) << 1
    high = int(root(square))
    return (high << 14) + (((square - high * high) << 14) + low) // (2 * high)


@micropython.viper
def allow(scratch: ptr32, limits: ptr32, axis: int, along: int):
    """Lower SCRATCH_ALONG and SCRATCH_STRENGTH to what `axis` allows; it moves by `along` > 0, of 2²⁸, of the path."""
    shift = int(lift(along, 0x8000000))
    if shift > 13:
        shift = 13
    part = (along << shift >> 13) + 1
    most = int(limit_along(limits[LIMIT_FASTEST + axis], part, limits[LIMIT_FASTEST_SHIFT + axis] - 1000 + shift))
    if most < scratch[SCRATCH_ALONG]:
        scratch[SCRATCH_ALONG] = most
    most = int(limit_along(limits[LIMIT_STRONGEST + axis], part, limits[LIMIT_STRONGEST_SHIFT + axis] - 1000 + shift))
    if most < scratch[SCRATCH_STRENGTH]:
        scratch[SCRATCH_STRENGTH] = most


@micropython.viper
def limit_along(limit: int, part: int, shift: int) -> int:
    """limit / part · 2^shift, at most 2²⁹: an axis's limit, along a path of which it moves by `part`."""
    limit = limit // part
    if shift < 0:
        return int(scale(limit, shift))
    if limit < 0x20000000 >> shift:
        return limit << shift
    return 0x20000000
