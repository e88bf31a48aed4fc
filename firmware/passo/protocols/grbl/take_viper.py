"""The one call of a batch of lines: from the bytes that have come to blocks in the planner's queue.

    taken = take_lines(data, len(data), lines.text, lines.fields, gcode.fields, batch.rows, batch.dots, read_dots, batch.most, *batch.taker)

    data ─► buffer_bytes() ─► text ─► parse() ─► rows ─► queue_lines(), the machine's ─► blocks

One text for all interpreters; see motion/block_viper.py.
"""
# `queue_lines` is usually passo.control.line_batches.queue_lines

import micropython
from micropython import const

from passo.protocols.gcode.parse_records import *
from passo.protocols.gcode.parse_viper import parse_lines
from passo.protocols.grbl.lines import ARC, LEFT, buffer_bytes
from passo.records import BATCH_ROWS, TRACE_ROOM, TRACE_TAKEN

_LINE_BYTES = const(24)  # of a short line. A call takes fewer lines if they are longer, because `?` waits until it ends


@micropython.viper
def take_lines(
    data: ptr8, count: int, text: ptr8, lines: ptr32, fields: ptr32, rows, dots: ptr32, read_dots, most: int, travel, queue_lines, target,
    blocks, scratch, indices, limits,
) -> int:
    """Keep `count` bytes of `data`, and have the machine take the plain ones of the kept lines: as many as it has room for, `most`
    at most, none while `?` waits. Returns how many; or what buffer_bytes() returns, or LEFT or ARC, and LINES_TAKEN is how many."""
    machine = ptr32(travel)
    taken = 0
    lines[LINES_TAKEN] = 0
    lines[LINES_WAITS] = 0
    if count:
        kept = int(buffer_bytes(data, count, text, lines))
        if kept:
            return kept
    while lines[LINES_ASKED] == 0 and lines[LINES_AT] < lines[LINES_WHOLE]:
        until = int(end_of(text, lines, most))
        part = most - taken
        if part > machine[TRACE_ROOM]:
            part = machine[TRACE_ROOM]
        if part > BATCH_ROWS:
            part = BATCH_ROWS
        lines[LINES_WAITS] = 1
        if part <= 0:
            break
        filled = int(parse_lines(text, lines[LINES_AT], until, fields, ptr32(rows), dots, read_dots, part))
        if filled:
            lines[LINES_AT] = fields[PARSE_AFTER]
            lines[LINES_FILLED] = filled
            queue_lines(rows, filled, target, travel, blocks, scratch, indices, limits)
            taken += machine[TRACE_TAKEN]
            lines[LINES_TAKEN] = taken
            if machine[TRACE_TAKEN] < filled:
                return LEFT
        if filled < part:
            if lines[LINES_AT] < until and fields[PARSE_NO_ROOM] == 0:
                lines[LINES_WAITS] = 0
                if fields[PARSE_ARC]:
                    return ARC
            break
    return taken


@micropython.viper
def end_of(text: ptr8, lines: ptr32, most: int) -> int:
    """Return where the lines of one call end: behind the line that reaches the bytes of `most` short ones. Above BATCH_ROWS, on a PC, all."""
    whole = lines[LINES_WHOLE]
    if most > BATCH_ROWS:
        return whole
    last = lines[LINES_AT] + _LINE_BYTES * most - 1
    while last < whole and text[last] != 10:
        last += 1
    return last + 1 if last < whole else whole
