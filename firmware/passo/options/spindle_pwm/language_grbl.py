"""Rows of dots in plain lines of G-code: their powers, from the text into the ring of Power.marks, DOTS_….

    S0:500:1000     each S by itself
    S=@@OT_H        a packed row, which ends its line: two characters a dot, `@` to `_`, are 32 · the first + the second, in
                    thousandths of full power; S stays as it was

One text for all interpreters; see motion/block_viper.py.
"""
# `read_dots` of passo.protocols.gcode.parse_viper is usually this one

import micropython

from passo.protocols.gcode.parse_records import *
from passo.protocols.gcode.parse_viper import power_thousandths, read_number, with_decimals
from passo.records import *


def extend(protocol, board):
    """Let lines be rows."""
    protocol.dots = read_dots


@micropython.viper
def read_dots(text: ptr8, at: int, count: int, fields: ptr32, dots: ptr32):
    """Read a row from the colon or the sign of equality behind its S on, and put its dots behind those that count. Writes PARSE_DOTS, PARSE_LAST and
    PARSE_DOTS_END; 0 and PARSE_NO_ROOM if the ring may have no room: each dot has two characters at least. To read the row in vain would
    take a Pico up to a millisecond."""
    fields[PARSE_DOTS_END] = 0
    if fields[PARSE_FULL] <= 1:
        return
    end = at
    while end < count and text[end] != 10:
        end += 1
    room = (dots[DOTS_TAIL] - dots[DOTS_HEAD] - 1) & dots[DOTS_MASK]
    if (end - at) >> 1 > room:
        fields[PARSE_NO_ROOM] = 1 if room < DOTS_MOST else 0  # else the line is too long
    elif text[at] == 58:
        read_row(text, at, end, fields, dots)
    elif fields[PARSE_HAVE] & HAS_S == 0:
        read_packed(text, at + 1, end, fields, dots)


@micropython.viper
def read_row(text: ptr8, at: int, end: int, fields: ptr32, dots: ptr32):
    """Read the powers of a row, the first being PARSE_TURNS, from the colon behind it on."""
    value = fields[PARSE_TURNS]
    row = 0
    while True:
        level = int(power_thousandths(value, fields[PARSE_FULL]))
        put_dot(dots, row, level)
        row += 1
        if at == end or text[at] != 58:
            break
        at = int(read_number(text, at + 1, end, fields))
        value = int(with_decimals(fields[PARSE_VALUE], fields[PARSE_DECIMALS], 3, 50000000))
        if at == 0 or fields[PARSE_MINUS] or value < 0 or value > 500000000:
            return
    fields[PARSE_DOTS] = row
    fields[PARSE_LAST] = level
    fields[PARSE_DOTS_END] = at


@micropython.viper
def read_packed(text: ptr8, at: int, end: int, fields: ptr32, dots: ptr32):
    """Read a packed row up to its line's end."""
    level = 0
    row = 0
    while at + 1 < end:
        high = int(text[at])
        at += 1
        low = int(text[at])
        if (high ^ 0x40) >> 5 or (low ^ 0x40) >> 5:
            return
        level = (high & 31) << 5 | low & 31
        if level > 1000:
            return
        put_dot(dots, row, level)
        row += 1
        at += 1
    if row == 0 or at < end:
        return
    fields[PARSE_DOTS] = row
    fields[PARSE_LAST] = level
    fields[PARSE_DOTS_END] = at


@micropython.viper
def put_dot(dots: ptr32, row: int, level: int):
    """Put dot number `row` of the row being read behind those that count."""
    dot = (dots[DOTS_HEAD] + row) & dots[DOTS_MASK]
    at = dots[DOTS_AT] + dot // 3
    by = dot % 3 * DOTS_COUNT
    dots[at] = dots[at] & ~(DOTS_POWER << by) | level << by
