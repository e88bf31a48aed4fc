"""Pulse files on the PC: reads them with the firmware's own protocol, draws them, and makes them from G-code with its walkers."""

from pathlib import Path

from host_tools.failure import Failure, reason
from passo.protocols.pulses.errors import NO_CODE

_LETTERS = {}


def load_pulses(path):
    """Read the bytes of a pulse file. Raises Failure, also if it has a control command in braces."""
    from host_tools.clients.pulses_wire import brace_in
    from host_tools.language import error_text

    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise Failure("cannot read {}: {}", path, reason(error)) from error
    brace = brace_in(data)
    if brace:
        raise Failure("{}:{}:{}: error {}: {}", path, *brace, NO_CODE, error_text(NO_CODE))
    return data


def read_items(data, axes, config, name="the file"):
    """Return the items of a file (see passo.commands). Raises Failure with line and column of the fault."""
    from host_tools.language import error_text
    from passo.options.step_program.commands import STEPS_ABORT, STEPS_ITEMS
    from passo.protocols.pulses.protocol import Pulses, frame

    protocol = Pulses(axes, config)
    found = []
    protocol.feed(frame("load", len(data)) + b"\n", 0)
    for command in protocol.feed(data, 0) + protocol.feed(frame("end"), 0):
        if command.value == STEPS_ABORT:
            line, column = command.target
            raise Failure("{}:{}:{}: error {}: {}", name, line, column, command.error, error_text(command.error))
        if command.value == STEPS_ITEMS:
            found += command.target
    return found


class Course:
    """Strokes, box, steps and time of a file."""

    def __init__(self, found, board):
        from passo.options.step_program.commands import STEPS_DEFAULT, STEPS_FASTEST, STEPS_SPEED, STEPS_TOOL, STEPS_WAIT
        from passo.options.step_program.control_orders import lengths_of

        axes = board["axes"]
        config = board["step_program"]
        lengths = lengths_of([axis["steps_per_m"] for axis in axes])
        fastest = min(lengths[1 << axis] for axis in range(len(axes))) // config["interval_us"]
        speed = min(config["default_mm_min"], fastest)
        scale = [axis["steps_per_m"] / 1000 for axis in axes]
        self.place = [0] * len(axes)
        self.low, self.high = self.place[:], self.place[:]
        self.steps = self.commands = 0
        self.seconds = 0.0
        tool = False
        self.strokes = [(False, [(0.0, 0.0)])]
        for item in found:
            mask, count = item & 15, item >> 8
            self.commands += count if mask else 1
            if not mask:
                kind = item >> 4 & 15
                if kind == STEPS_TOOL:
                    tool = bool(count)
                    self.strokes.append((tool, [self.strokes[-1][1][-1]]))
                elif kind == STEPS_WAIT:
                    self.seconds += count / 1000
                elif kind in (STEPS_SPEED, STEPS_FASTEST, STEPS_DEFAULT):
                    speed = {STEPS_SPEED: count, STEPS_FASTEST: fastest, STEPS_DEFAULT: config["default_mm_min"]}[kind]
                    speed = min(speed, fastest)
                continue
            self.steps += count
            self.seconds += count * ((lengths[mask] + speed // 2) // speed) / 1e6
            for axis in range(len(axes)):
                if mask >> axis & 1:
                    self.place[axis] += -count if item >> 4 + axis & 1 else count
                    self.low[axis] = min(self.low[axis], self.place[axis])
                    self.high[axis] = max(self.high[axis], self.place[axis])
            if mask & 3:
                self.strokes[-1][1].append((self.place[0] / scale[0], self.place[1] / scale[1] if len(axes) > 1 else 0.0))
        self.strokes = [stroke for stroke in self.strokes if len(stroke[1]) > 1]


def letter_of(mask, negative):
    """Return the code of one step; `mask`: the axes that step, `negative`: those that step back."""
    from passo.protocols.pulses.codes import CODES

    if not _LETTERS:
        _LETTERS.update({code: chr(65 + number) for number, code in enumerate(CODES)})
    return _LETTERS[negative << 4 | mask]


class Converter:
    """Lines of G-code to the text of a pulse file: the G-code reader and the lines and circles are the firmware's."""

    def __init__(self, board):
        from array import array

        from passo.config.journal import Journal, MemorySlots
        from passo.config.settings import Settings
        from passo.control import arcs
        from passo.motion.circle import Circle
        from passo.motion.line import MAX_RUN, Line
        from passo.protocols.gcode.offsets import Offsets
        from passo.protocols.gcode.parser import GCode
        from passo.records import ARC_FIELDS

        axes = board["axes"][:3]
        self.steps_per_m = [axis["steps_per_m"] for axis in axes]
        self.target = [0] * len(axes)
        self.arcs = arcs  # the face that the G-code reader wants: also steps_per_m and target
        self._gcode = GCode("xyz"[: len(axes)], Offsets(len(axes), Settings(board, Journal(MemorySlots()))), self)
        self._line = Line(len(axes))
        self._circle = Circle(len(axes))
        self._plan = array("i", [0] * ARC_FIELDS)
        self._out = array("I", [0] * MAX_RUN)
        self._parts = ["["]
        self._speed = None
        self._tool = False

    def convert(self, lines):
        """Return the text of a pulse file for [(number, bytes)], up to M2 or M30. Raises Failure at the first line that cannot be converted. If the
        program has no S at all, M3 and M4 switch the tool on. If it has, S0 keeps the tool off, as on a machine with a spindle."""
        from host_tools.programs.pulse_shapes import break_lines as folded
        from host_tools.language import error_text

        if not any(b"S" in line.upper() for _, line in lines):
            self._gcode.rpm = self._gcode.max_rpm
        for number, line in lines:
            error = self._gcode.interpret_line(line)
            if error:
                raise Failure("line {}: {}: error {}: {}", number, line.decode(), error, error_text(error))
            for command in self._gcode.commands:
                self._put_command(number, line, command)
            if self._gcode.ended:
                break
        self._set_tool(False)
        self._parts.append("]")
        text = []
        for part in self._parts:
            text.append(folded(part) if part[0].isalpha() else part + "\n")
        return "".join(text)

    def _put_command(self, number, line, command):
        """Append the text of one command of line `number`: a motion with its tool and speed, a dwell in whole ms, a pause as `+0`. Raises Failure if
        a pulse file has no word for it."""
        from passo import commands

        kind = command.kind
        if kind in (commands.LINE, commands.ARC):
            self._set_tool(bool(command.tool))
            self._set_speed(number, line, command)
            self._put_walk(number, line, command, kind == commands.ARC)
            self.target = list(command.target)
        elif kind == commands.DWELL:
            if command.value >= 1000:
                self._parts.append(f"*{min(command.value // 1000, 3_600_000)}")
        elif kind == commands.PAUSE:
            self._parts.append("+0")
            self._speed = None
        elif kind == commands.SPINDLE:
            self._set_tool(bool(command.tool))
        elif kind not in (commands.COOLANT, commands.SYNC, commands.OVERRIDE):  # the last: M2 ends every override
            raise Failure("line {}: {}: a pulse file has no word for that", number, line.decode())

    def _set_tool(self, on):
        if on != self._tool:
            self._tool = on
            self._parts.append("(" if on else ")")

    def _set_speed(self, number, line, command):
        """Append a command's speed in mm/min, 1 to 900 000, if it is another one; `$` for a rapid. Raises Failure with G93."""
        if command.per_min:
            raise Failure("line {}: {}: inverse time (G93) has no place in a pulse file", number, line.decode())
        speed = max(round(command.feed * 60 / 1_000_000), 1) if command.feed else 0
        if speed != self._speed:
            self._speed = speed
            self._parts.append(f"+{min(speed, 900_000)}" if speed else "$")

    def _put_walk(self, number, line, command, arc):
        """Append the letters of a line's or an arc's steps, as the firmware's walkers make them. Raises Failure if they refuse it."""
        deltas = [to - at for at, to in zip(self.target, command.target)]
        letters = []
        try:
            for walker in self._walkers_of(command, deltas) if arc else self._line_walkers([deltas]):
                while walker.left:
                    count = min(walker.left, len(self._out))
                    negative = walker.negative
                    walker.walk(self._out, 0, count)
                    letters += [letter_of(mask, negative & mask) for mask in self._out[:count]]
        except ValueError as error:
            raise Failure("line {}: {}: {}", number, line.decode(), error) from error
        if letters:
            self._parts.append("".join(letters))

    def _line_walkers(self, all_deltas):
        """Yield the firmware's walker, set up for one line after the other."""
        for deltas in all_deltas:
            if any(deltas):
                self._line.begin(deltas)
                yield self._line

    def _walkers_of(self, command, deltas):
        """Return the walkers of an arc: a circle's, or as in control.stream_queue those of its chords."""
        from passo.motion import arc
        from passo.motion.ellipse import Ellipse

        first, second = command.first, command.second
        plane = (first, second, 3 - first - second if len(deltas) > 2 else -1)
        given = plane, command.centre
        turns = command.clockwise, command.turns - 1, command.over_half
        if self.steps_per_m[first] == self.steps_per_m[second]:
            try:
                arc.plan(self._plan, *given, deltas, *turns)
                self._circle.load(self._plan)
                return [self._circle]
            except ValueError:  # too large, or too steep a helix
                pass
        ellipse = Ellipse(deltas, *given, self.steps_per_m, *turns)
        return self._line_walkers(ellipse.chord() for _ in range(ellipse.left))
