"""Numbers as text in a buffer that is used again and again: what a status report is made of, without garbage.

    figures = array("i", [0] * (AXES + 4 * axes))
    figures[AXES:AXES + 4] = …                      # of the first axis: steps, steps a metre, offset: mm, and nm above it
    places(figures, axes, MACHINE, 0)               # the numbers to be told
    at = tell(out, 0, b"MPos:\\0", figures, axes)   # MPos:0.000,-1.250,…

A number is three integers: whole (or ~whole of a negative one), decimals, and how many of these. Places are told to 1000 km.
One text for all interpreters, as motion/measure_viper.py: a board compiles it to machine code.
"""
# ruff: noqa: F821

import micropython
from micropython import const

try:
    ptr32, ptr8
except NameError:
    ptr32 = ptr8 = None  # names that only viper's compiler knows

AXES = const(12)  # where the axes begin in the figures, behind room for four numbers
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
        width = 1
        unit = 10
        while width < 10 and value >= unit:
            width += 1
            unit *= 10
        part = 0
        while part < 2:
            if part and width:
                out[at] = 46
                at += 1
            at += width
            place = at
            while width:
                place -= 1
                tenth = value // 10
                out[place] = 48 + value - 10 * tenth
                value = tenth
                width -= 1
            value = figures[number + 1]
            width = figures[number + 2]
            part += 1
        number += 3
        count -= 1
    return at


@micropython.viper
def places(figures: ptr32, axes: int, which: int, inches: int):
    """Where the axes are, or the offsets, as numbers: millimetres with three decimals or inches with four, of whole
    nanometres; both are rounded halves away from zero."""
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
            part = nm // 1_000_000
            nm -= 1_000_000 * part
            mm = 1000 * (mm if mm < 1_000_000 else 1_000_000) + part
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
        decimals = 3
        if inches:
            decimals = 4
            part = mm // 127  # five inches
            nm = ((mm - 127 * part) * 1_000_000 + nm + 1270) // 2540
            mm = nm // 10_000
            nm -= 10_000 * mm
            mm += 5 * part
        else:
            nm = (nm + 500) // 1000
            if nm == 1000:
                mm += 1
                nm = 0
        figures[number] = ~mm if negative and mm + nm else mm
        figures[number + 1] = nm
        figures[number + 2] = decimals
        number += 3
        at += 4
        axes -= 1
