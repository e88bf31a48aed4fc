"""A black box's (control.py) view of a link that speaks grbl: the lines that have come, and the state by which the next one is read. Only
boards that have one load it.

    log = Log(*protocol.sources(), size)    # before the link's first line: the line buffer then keeps `size` bytes of what has come
    log.text, log.fields                    # bytes; fields[log.at]: those before it have been taken; fields[log.end]: all
    log.write_state(numbers, index)         # FAST + SLOW numbers, see below
"""

from passo.protocols.gcode.parse_records import *

FAST = 9  # PARSE_KNOWN, PARSE_MODAL … the last PARSE_POSITION, PARSE_NUMBER, PARSE_RPM
# Motion, line number, tool, plane, coolant, and 1 G20 + 2 G90 + 4 G94 + 8 G98 + 16 × modes of the cycle + 64 × spindle + 512 × G54 … as 0 …;
# then two numbers each, the low 30 bits first: feed, S, position, cycle, G92 of four axes, tool length.
SLOW = 6 + 2 * (2 + 4 + 5 + 4 + 1)


class Log:
    at = LINES_AT
    end = LINES_END
    orders = True  # real-time bytes are not in the text

    def __init__(self, lines, gcode, size):
        """`size`: bytes of the text; eight more are behind it."""
        lines.fields[LINES_SIZE] = size + 8
        lines.make_buffer()
        self.text = lines.text
        lines.fields[LINES_SIZE] = size
        self._gcode = gcode
        self.fields = lines.fields
        self._known = 0  # PARSE_KNOWN as `_slow` is of; even: of no time
        self._slow = self.fields[:0]

    def drop_bytes(self, text, by):
        """Forget the first `by` bytes, which have been taken."""
        fields = self.fields
        for field in (LINES_AT, LINES_WHOLE, LINES_END):
            fields[field] -= by
        text[: fields[LINES_END]] = memoryview(text)[by : by + fields[LINES_END]]

    def write_state(self, numbers, index):
        """Write FAST + SLOW numbers, by which the parser understands the next line, to numbers[index:]."""
        fields = self._gcode.fields
        known = fields[PARSE_KNOWN]
        numbers[index] = known
        numbers[index + 1 : index + FAST - 2] = fields[PARSE_MODAL : PARSE_POSITION + 4]
        numbers[index + FAST - 2] = fields[PARSE_NUMBER]
        numbers[index + FAST - 1] = fields[PARSE_RPM]
        if known & 1 == 0 or known != self._known:
            self._known = known
            self._write_slow(numbers, index + FAST)
            self._slow = numbers[index + FAST : index + FAST + SLOW]
        else:
            numbers[index + FAST : index + FAST + SLOW] = self._slow

    def _write_slow(self, numbers, index):
        """Write the SLOW numbers, those that few lines change, to numbers[index:]."""
        gcode = self._gcode
        modes = (1 if gcode.inches else 0) | (2 if gcode.absolute else 0) | (4 if gcode.per_minute else 0) | (8 if gcode.initial else 0)
        modes |= gcode.cycle[0] << 4 | gcode.spindle << 6 | gcode.system << 9
        for value in (gcode.motion, gcode.number, gcode.tool, gcode.plane, gcode.coolant, modes):
            numbers[index] = value
            index += 1
        more = [0] * (4 - gcode.axes)
        long = [gcode.feed, gcode.rpm] + list(gcode.position) + more + list(gcode.cycle[1:])
        for value in long + list(gcode.offsets.shift) + more + [gcode.offsets.tool]:
            numbers[index] = value & 0x3FFFFFFF
            numbers[index + 1] = value >> 30
            index += 2
