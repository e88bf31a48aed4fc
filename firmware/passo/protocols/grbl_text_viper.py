"""Numbers as text in a buffer that is used again and again: what a status report is made of, without garbage.

    figures = array("i", [0] * (AXES + 4 * axes))
    figures[UNITS:AXES] = MILLIMETRES
    figures[AXES:AXES + 4] = …                      # of the first axis: steps, steps a metre, offset: mm, and nm above it
    places(figures, axes, MACHINE)                  # the numbers to be told
    at = tell(out, 0, b"MPos:\\0", figures, axes)   # MPos:0.000,-1.250,…

A number is three integers: whole (or ~whole of a negative one), decimals, and what the first of these is worth, 0 where
there is none. Places are told to 100 km, offsets too.
One text for all interpreters, as motion/measure_viper.py: a board compiles it to machine code.
"""
# ruff: noqa: F821

from array import array

import micropython
from micropython import const

try:
    ptr32, ptr8
except NameError:
    ptr32 = ptr8 = None  # names that only viper's compiler knows

# The figures: room for three numbers, the unit of places, then four integers an axis.
UNITS = const(9)
AXES = const(12)
# Tenths of a millimetre a unit, nanometres a unit of the last decimal, the first decimal.
MILLIMETRES = array("i", (10, 1000, 100))
INCHES = array("i", (254, 2540, 1000))
MACHINE = const(0)
PROGRAMME = const(1)
OFFSET = const(2)  # between the two


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
        if value < 0:
            out[at] = 45
            at += 1
            value = ~value
        unit = 1
        while value // unit > 9:
            unit *= 10
        decimal = figures[number + 2]
        while unit:
            digit = value // unit
            out[at] = 48 + digit
            at += 1
            value -= digit * unit
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
def places(figures: ptr32, axes: int, which: int):
    """Where the axes are, or the offsets, as numbers in the figures' unit: of whole nanometres, which are rounded as they
    are, halves away from zero."""
    number = 0
    at = 12
    while axes:
        negative = which >> 1
        mm = 0
        nm = 0
        if not negative:
            left = figures[at]
            if left < 0:
                left = 0 - left
            per_m = figures[at + 1]
            mm = left // per_m
            left -= mm * per_m
            digits = 9
            while digits:
                left *= 10
                part = left // per_m
                left -= part * per_m
                nm = 10 * nm + part
                digits -= 1
            if left + (per_m >> 1) >= per_m:
                nm += 1
            if mm > 100_000:
                mm = 100_000
            part = nm // 1_000_000
            nm -= 1_000_000 * part
            mm = 1000 * mm + part
            if figures[at] < 0:
                mm = 0 - mm
                nm = 0 - nm
        if which:
            mm -= figures[at + 2]
            nm -= figures[at + 3]
        while mm < 0 or nm < 0:
            if nm < 0:
                nm += 1_000_000
                mm -= 1
            else:
                mm = 0 - mm
                nm = 0 - nm
                negative ^= 1
        mm *= 10
        part = mm // figures[9]
        nm += (mm - part * figures[9]) * 100_000 + (figures[10] >> 1)
        nm //= figures[10]
        if nm == 10 * figures[11]:
            part += 1
            nm = 0
        figures[number] = ~part if negative and part + nm else part
        figures[number + 1] = nm
        figures[number + 2] = figures[11]
        number += 3
        at += 4
        axes -= 1
