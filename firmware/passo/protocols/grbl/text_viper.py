"""Numbers as text in a buffer that is used again and again: a status report is made of them, without garbage.

    at = write_report(out, form, fields, seen, steps, axes)  # all that is told each time, from what was seen of one moment (SEEN_…)

    fields = array("i", [0] * (REPORT_AXIS + REPORT_FIELDS * axes))
    fields[REPORT_UNIT:REPORT_AXIS] = MILLIMETRES
    fields[REPORT_AXIS + REPORT_STEPS_PER_M] = …     # of the first axis, and its offset
    set_lengths(fields, steps, axes)                 # the numbers: an array of steps as lengths, less the offsets
    at = write_form(out, 0, b"MPos:\\1,\\2\\0", fields)      # MPos:0.000,-1.250

The fields are REPORT_… and NUMBER_… of report_records.py. Positions are written up to 100 km, offsets too. One text for all interpreters; see
motion/block_viper.py.
"""

from array import array

import micropython
from micropython import const

from passo.protocols.grbl.report_records import *
from passo.records import SEEN_LINE, SEEN_MM_S, SEEN_NM_S, SEEN_ROOM

FARTHEST_MM = const(100_000_000)
_LONGEST_NUMBER = const(16)  # bytes: sign, ten digits, point, four decimals
# REPORT_UNIT, REPORT_DECIMAL, REPORT_FIRST.
_TENTHS_MM = const(10)
MILLIMETRES = array("i", (_TENTHS_MM, 1000, 100))
INCHES = array("i", (254, 2540, 1000))


@micropython.viper
def write_report(out: ptr8, form: ptr8, fields: ptr32, seen: ptr32, steps: ptr32, axes: int) -> int:
    """Write `form` as write_form() does, its numbers from `seen`, and from where the axes are; returns where it ends."""
    set_lengths(fields, steps, axes)
    fields[REPORT_BLOCKS + NUMBER_WHOLE] = seen[SEEN_ROOM]
    fields[REPORT_LINE + NUMBER_WHOLE] = seen[SEEN_LINE]
    set_speed(fields, seen[SEEN_MM_S], seen[SEEN_NM_S])
    return int(write_form(out, 0, form, fields))


@micropython.viper
def set_speed(fields: ptr32, mm_s: int, nm_s: int):
    """Set a speed as a number, whole mm/min or tenths of an inch a minute, rounded: mm_s, 27 000 at most, and nm_s below a mm/s."""
    if fields[REPORT_UNIT] == _TENTHS_MM:
        fields[REPORT_SPEED + NUMBER_WHOLE] = 60 * mm_s + (3 * nm_s + 25_000) // 50_000
        return
    tenths = 23 * mm_s + (79_000 * mm_s + 3 * nm_s + 63_500) // 127_000
    fields[REPORT_SPEED + NUMBER_WHOLE] = tenths // 10
    fields[REPORT_SPEED + NUMBER_DECIMALS] = tenths % 10


@micropython.viper
def write_form(out: ptr8, at: int, form: ptr8, fields: ptr32) -> int:
    """Write `form`, which a zero byte ends, at out[at]; a byte of less than a line feed stands for a number of `fields`, 1 for
    the first. Returns where that ends; `at` where it might go beyond REPORT_LONGEST, which `out` has room for."""
    index = 0
    begin = at
    while form[index]:
        if at > REPORT_LONGEST - _LONGEST_NUMBER:
            return begin
        byte = int(form[index])
        index += 1
        if byte > 9:
            out[at] = byte
            at += 1
            continue
        number = REPORT_NUMBER + NUMBER_FIELDS * (byte - 1)
        value = fields[number + NUMBER_WHOLE]
        decimal = fields[number + NUMBER_FIRST]
        if decimal >= NUMBER_NEGATIVE:
            out[at] = 45
            at += 1
            decimal -= NUMBER_NEGATIVE
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
                value = fields[number + NUMBER_DECIMALS]
                unit = decimal
                decimal = 0
    return at


@micropython.viper
def set_lengths(fields: ptr32, steps: ptr32, axes: int):
    """Set the positions of the axes, less the offsets, as numbers in the report's unit: of whole nanometres, which are rounded as they are,
    halves away from zero.
    """
    axis = 0
    number = REPORT_NUMBER
    at = REPORT_AXIS
    while axis < axes:
        left = steps[axis]
        sign = 1
        if left >> 30 & 1:
            left = (0 - left) & 0x3FFFFFFF
            sign = -1
        per_m = fields[at + REPORT_STEPS_PER_M]
        mm = left // per_m
        if mm > 100_000:
            mm = 100_000
        unit = 1000 if per_m < 2_000_000 else 10  # of decimals at a time: no product reaches 2³¹
        nm = 1
        while nm < 1_000_000_000:
            left = left % per_m * unit
            nm = nm * unit + left // per_m
        nm -= 1_000_000_000
        if left % per_m + (per_m >> 1) >= per_m:
            nm += 1
        mm = (1000 * mm + nm // 1_000_000) * sign + FARTHEST_MM - fields[at + REPORT_OFFSET_MM]
        nm = nm % 1_000_000 * sign - fields[at + REPORT_OFFSET_NM]
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
        unit = fields[REPORT_UNIT]
        nm += mm % unit * 100_000
        mm //= unit
        unit = fields[REPORT_DECIMAL]
        nm = (nm + (unit >> 1)) // unit
        unit = fields[REPORT_FIRST]
        if nm >= 10 * unit:
            nm -= 10 * unit
            mm += 1
        if sign < 0 and mm + nm:
            unit |= NUMBER_NEGATIVE
        fields[number + NUMBER_WHOLE] = mm
        fields[number + NUMBER_DECIMALS] = nm
        fields[number + NUMBER_FIRST] = unit
        number += NUMBER_FIELDS
        at += REPORT_FIELDS
        axis += 1
