"""The dots of a row on their way from a line into the ring of Power.marks, DOTS_….

    if row_waits(text, at, count, dots) == 0:       # before the line is read
        put_dot(dots, row, level)                   # each, while it is read
        add_row(fields, dots)                       # once all of the line is right

One text for all interpreters; see motion/block_viper.py.
"""

import micropython

from passo.protocols.gcode.parse_records import *
from passo.records import *


@micropython.viper
def put_dot(dots: ptr32, row: int, level: int):
    """Put dot number `row` of the row being read behind those that count, if there is room for it."""
    dot = (dots[DOTS_HEAD] + row) & dots[DOTS_MASK]
    if row < int(dots_room(dots)):
        at = dots[DOTS_AT] + dot // 3
        by = dot % 3 * DOTS_COUNT
        dots[at] = dots[at] & ~(DOTS_POWER << by) | level << by


@micropython.viper
def row_waits(text: ptr8, at: int, count: int, dots: ptr32) -> int:
    """Return 1 if the line at text[at] is a row and the ring may have no room for its dots: each has two characters at least. Takes a Pico
    20 µs; to read the row in vain would take up to a millisecond. `$` lines never wait."""
    room = int(dots_room(dots))
    if dots[DOTS_MASK] == 0 or room >= DOTS_MOST or text[at] == 36:
        return 0
    while at < count and text[at] != 10 and text[at] != 58 and text[at] != 61:
        at += 1
    begin = at
    while at < count and text[at] != 10:
        at += 1
    return 1 if (at - begin) >> 1 > room else 0


@micropython.viper
def dots_room(dots: ptr32) -> int:
    """Return for how many more dots the ring has room."""
    return (dots[DOTS_TAIL] - dots[DOTS_HEAD] - 1) & dots[DOTS_MASK]


@micropython.viper
def add_row(fields: ptr32, dots: ptr32) -> int:
    """Count the dots of the row just read as queued. Returns 1; 0 and PARSE_NO_ROOM if the ring has no room for them now."""
    row = fields[PARSE_DOTS]
    head = dots[DOTS_HEAD]
    if row > int(dots_room(dots)):
        fields[PARSE_NO_ROOM] = 1
        return 0
    fields[PARSE_POWER] = fields[PARSE_LAST] | row << DOTS_COUNT | head << DOTS_FIRST
    dots[DOTS_HEAD] = (head + row) & dots[DOTS_MASK]
    return 1
