"""Numbers as text in a buffer that is used again and again: what a status report is made of, without garbage.

    figures = array("i", [0] * (AXES + 3 * axes))
    figures[UNITS:AXES] = MILLIMETRES
    figures[AXES:AXES + 3] = …                      # of the first axis: steps a metre, offset: FARTHEST_MM + whole
                                                    # millimetres, and nm above them
    places(figures, steps, axes)                    # the numbers to be told: an array of steps as lengths, less the offsets
    at = tell(out, 0, b"MPos:\\0", figures, axes)   # MPos:0.000,-1.250,…

A number is three integers: whole, decimals, and what the first of these is worth (0 where there is none), plus 65 536 where
it is negative. Places are told to 100 km, offsets too.
One text for all interpreters, as motion/measure_viper.py, whose rules for integers are kept: a board compiles it to machine
code.
"""
# ruff: noqa: F821

from array import array

import micropython
from micropython import const

try:
    ptr32, ptr8
except NameError:
    ptr32 = ptr8 = None  # names that only viper's compiler knows

# The figures: room for three numbers, the unit of places, then three integers an axis.
UNITS = const(9)
AXES = const(12)
FARTHEST_MM = const(100_000_000)
# Tenths of a millimetre a unit, nanometres a unit of the last decimal, the first decimal.
MILLIMETRES = array("i", (10, 1000, 100))
INCHES = array("i", (254, 2540, 1000))


@micropython.viper
def tell(out: ptr8, at: int, label: ptr8, figures: ptr32, count: int) -> int:
    """Write `label`, which a zero byte ends, and the first `count` numbers with commas in between at out[at]. Returns where
    that ends."""
    place = 0
    while label[place]:
        out[at] = label[place]
        at += 1
        place += 1
    number = 0
    while count:
        if number:
            out[at] = 44
            at += 1
        value = figures[number]
        decimal = figures[number + 2]
        if decimal >> 16:
            out[at] = 45
            at += 1
            decimal &= 0xFFFF
        unit = 1
        while value // unit > 9:
            unit *= 10
        while unit:
            out[at] = 48 + value // unit
            at += 1
            value %= unit
            unit //= 10
            if unit == 0 and decimal:
                out[at] = 46
                at += 1
                value = figures[number + 1]
                unit = decimal
                decimal = 0
        number += 3
        count -= 1
    return at


@micropython.viper
def places(figures: ptr32, steps: ptr32, axes: int):
    """Where the axes are, less the offsets, as numbers in the figures' unit: of whole nanometres, which are rounded as
    they are, halves away from zero."""
    axis = 0
    number = 0
    at = 12
    while axis < axes:
        left = steps[axis]
        sign = 1
        if left >> 30 & 1:
            left = (0 - left) & 0x3FFFFFFF
            sign = -1
        per_m = figures[at]
        mm = left // per_m
        if mm > 100_000:
            mm = 100_000
        nm = 0
        digits = 9
        while digits:
            left = left % per_m * 10
            nm = 10 * nm + left // per_m
            digits -= 1
        if left % per_m + (per_m >> 1) >= per_m:
            nm += 1
        mm = (1000 * mm + nm // 1_000_000) * sign + 100_000_000 - figures[at + 1]
        nm = nm % 1_000_000 * sign - figures[at + 2]
        sign = 1
        while mm < 0 or nm < 0:
            if nm < 0:
                nm += 1_000_000
                mm -= 1
            else:
                mm = 0 - mm
                nm = 0 - nm
                sign = 0 - sign
        mm *= 10
        unit = figures[9]
        nm += mm % unit * 100_000
        mm //= unit
        unit = figures[10]
        nm = (nm + (unit >> 1)) // unit
        unit = figures[11]
        if nm >= 10 * unit:
            nm -= 10 * unit
            mm += 1
        if sign < 0 and mm + nm:
            unit |= 0x10000
        figures[number] = mm
        figures[number + 1] = nm
        figures[number + 2] = unit
        number += 3
        at += 3
        axis += 1
