"""The state of a G-code program at any of its lines, and the lines that bring a machine into it: state is replayed, nothing moves.

    replay = Replay(Machine.of_answers(settings, parameters), lines)
    stages, rest = replay.from_line(120)                # begin at a line
    stages, rest = replay.from_place(120, [3200, 0, -400])      # go on amid that line, at this place in steps

Lines are understood by the firmware's own parser, so state is what the board would have. `stages` are (what, [lines]) to be sent one after
the other: the operator is asked before the one called DOWN. `rest` are the lines of the program still to be sent. Lengths are
millimetres in machine coordinates.
"""

import itertools
import re
from dataclasses import replace

from host_tools.clients.grbl import explain_error
from host_tools.clients.grbl_wire import number_line
from host_tools.failure import Failure
from host_tools.programs.replay_machine import AXES, ENDLESS, NM, Board, Memory, commands_of, exact_words
from passo import commands, errors
from passo.protocols.gcode.codes import CODES, CYCLE, G73, G82, G83, MOTION
from passo.protocols.gcode.offsets import SYSTEMS, TOOL_AXIS, Offsets
from passo.protocols.gcode.parser import GCode
from passo.protocols.gcode.reader import NONE
from passo.protocols.gcode.words import longest_line

OFFSETS, UP, OVER, OUTPUTS, DOWN, GO = "offsets", "tool up", "to the place", "spindle and coolant", "tool down", "go on"
_CLEARANCE_MM = 1.0
_PLUNGE_MM_MIN = 100.0  # as long as the program has no feed
_NEAR_STEPS = 2  # from the path: the most that rounding makes
_CHANGES = re.compile(rb"G0*10(?!\d)|G(28|30)\.1")  # lines that change what outlasts the program
_OTHER_MM = 1.0
_DOTS_A_LINE = 8  # so that it is no line too long


def _is_near(place, other):
    return all(abs(one - two) <= _NEAR_STEPS for one, two in zip(place, other))


class RefusedLine(Failure):
    """The parser refuses line `number` of the file, by the number `error`."""

    def __init__(self, text, number, line, error):
        super().__init__(text, number, line.decode("ascii", "replace"), explain_error(f"error:{error}", line))
        self.number = number
        self.error = error


class Replay:
    def __init__(self, machine, lines, start=None):
        """`lines`: [(number, bytes)] of gcode_file.read(). `start`: where the machine stands before them, steps; None: at zero."""
        self._machine = machine
        self._lines = lines
        self._board = Board(machine)
        self._board.target = list(start or self._board.target)
        self._offsets = Offsets(len(machine.steps_per_mm), Memory(machine))
        self._gcode = GCode(AXES[: len(machine.steps_per_mm)].lower(), self._offsets, self._board)
        self._gcode.turns = machine.turns
        self._gcode.laser = machine.laser
        self._gcode.max_rpm = round(machine.max_rpm * 1000)
        self._highest = None
        self._loose = False  # the start of the line under way is not known
        self.dot = None  # (number, how many) of the one at which a row of dots goes on
        self.held = {}  # the state at the line to go on with: filled by from_line() and from_place()

    # --- the two ways in

    def from_line(self, number, end=None):
        """Begin at line `number` of the file, at the end of the lines before it; return (stages, the other lines). `end`: where the machine has been
        there, steps. Raises Failure."""
        at = self._index_of(number)
        for index in range(at):
            self._carry_out(index)
        if end and not _is_near(end, self._board.target):
            raise Failure(
                "before line {} the machine was at {}, and by the file it is at {}: the file or zero has changed, or it began elsewhere",
                number, self._position_text(end), self._position_text(self._board.target),
            )
        return self._build_stages(self._level_place(), None), self._remaining_rows(at)

    def _level_place(self):
        """Return the program's position in steps. In a series of cycles Z is at least the height to which G98 returns, at which the series begins
        anew."""
        place = list(self._board.target)
        if CODES.get(self._gcode.motion, 0) & CYCLE:
            height = self._gcode.cycle[1] + self._offsets.offset_of(self._gcode.system, TOOL_AXIS)
            place[TOOL_AXIS] = max(place[TOOL_AXIS], round(height / NM * self._machine.steps_per_mm[TOOL_AXIS]))
        return place

    def from_place(self, number, place):
        """Go on amid line `number`, at `place` (steps from machine zero) on its way. A line that is neither a
        single straight motion nor an arc of one turn at most is done again from its start. Raises Failure if the place is not on its path."""
        at = self._index_of(number)
        for index in range(at):
            self._carry_out(index)
        start = list(self._board.target)
        before = self._build_stages(self._level_place(), None)
        motion = self._single_motion(at)
        if motion is None or list(place) == start:
            return before, self._remaining_rows(at)
        if not self._loose and not self._on_path(motion, start, place):
            raise Failure("line {}: the place {} is not on its path; the file, or zero, has changed", number, self._position_text(place))
        self._board.target = list(motion.target)
        if list(place) == list(motion.target):
            return self._build_stages(list(place), None), self._remaining_rows(at + 1)
        if motion.dots:
            modes, moving, after = [f"G90G21{self._feed_words(motion)}"], self._dots_left(motion, start, place), [f"S{self._gcode.rpm / 1000:.3f}"]
        else:
            *modes, last = self._remaining_lines(motion, start, place)
            moving, after = [last], []
        moving = [self._with_number(at, line) for line in moving]
        return self._build_stages(list(place), [*modes, *moving, *after]), self._remaining_rows(at + 1)

    def _with_number(self, at, line):
        """Return `line` with the number of line `at`, so that the journal counts it as that line."""
        return number_line(self._lines[at][0], line.encode()).decode()

    # --- what is not known of how the program began

    def check_offsets(self, number):
        """Raise Failure if from line `number` on the program relies on offsets that it changes later, or has changed: their values at its beginning
        are not known."""
        changed = self._find_changes()
        if not changed:
            return
        at = self._index_of(number)
        twins = [Replay(machine, self._lines) for machine in (self._machine, self._with_other_offsets(changed))]
        for index in range(len(self._lines)):
            for twin in twins:
                twin._carry_out(index)
            first, second = twins
            if index >= at - 1:
                if first._board.target != second._board.target:
                    raise Failure(
                        "line {} relies on {}, which the program changes: what it was when it began is not known; set it, then "
                        "passo stream --from",
                        self._lines[index][0], ", ".join(sorted(changed)),
                    )
                if first._offsets.systems == second._offsets.systems and first._offsets.homes == second._offsets.homes:
                    return

    def _find_changes(self):
        """Return {"G54": axes} of the positions that the program changes for good."""
        changed = {}
        for _, line in self._lines:
            found = _CHANGES.search(line.upper())
            if not found or line.startswith(b"$"):
                continue
            if found[1]:
                changed["G" + found[1].decode()] = set(range(len(AXES)))
                continue
            words = dict(re.findall(rb"([PLXYZA])([-+.\d]+)", line.upper()))
            axes = {AXES.index(letter.decode()) for letter in words if letter in AXES.encode()}
            system = int(float(words.get(b"P", 0)))
            if float(words.get(b"L", 0)) == 1:
                changed[f"T{system}"] = {2}
                continue
            for each in [system - 1] if system else range(SYSTEMS):
                changed.setdefault(f"G{54 + each}", set()).update(axes)
        return changed

    def _with_other_offsets(self, changed):
        """Return a copy of the machine with other values at those positions."""
        machine = self._machine
        count = len(machine.steps_per_mm)
        systems = dict(machine.systems)
        for name in [name for name in changed if name[0] == "G"]:
            places = systems.get(name, [0.0] * count)
            systems[name] = [place + (_OTHER_MM if axis in changed[name] else 0) for axis, place in enumerate(places)]
        tools = {name: machine.tools.get(name, 0.0) + _OTHER_MM for name in changed if name[0] == "T"}
        return replace(machine, systems=systems, tools={**machine.tools, **tools})

    def from_start(self, number, place, done):
        """Return the Replay that begins where the machine stood when the program did, as far as that decides anything: found from `place`, where it
        was when the line before `number` was `done`, or amid line `number`. Raises Failure if that does not tell."""
        at = self._index_of(number)
        twins = [Replay(self._machine, self._lines, [round(by * scale) for scale in self._machine.steps_per_mm]) for by in (0, _OTHER_MM)]
        for twin in twins:
            for index in range(at):
                twin._carry_out(index)
        first, second = twins
        here = list(first._board.target)
        doubted = [axis for axis in range(len(here)) if here[axis] != second._board.target[axis]]
        unsure = [axis for axis in range(len(here)) if first._all_offsets(axis) != second._all_offsets(axis) and axis not in doubted]
        motions = [None if done else twin._single_motion(at) for twin in twins]
        start = [0] * len(here)
        loose = False
        for axis in doubted:
            if done or motions[0] and motions[0].target[axis] == here[axis]:
                start[axis] = place[axis] - here[axis]
            elif motions[0] and motions[0].kind == commands.LINE and not motions[0].per_min and motions[0].target[axis] == motions[1].target[axis]:
                loose = True  # it comes from anywhere
            else:
                unsure.append(axis)
        if unsure:
            raise Failure(
                "line {}: where {} stood when the program began is not known, and decides where this line is; begin with passo "
                "stream --from",
                self._lines[at][0], AXES[unsure[0]],
            )
        made = Replay(self._machine, self._lines, start)
        made._loose = loose
        return made

    def _all_offsets(self, axis):
        offsets = self._offsets
        return [offsets.offset_of(system, axis) for system in range(SYSTEMS)], [places[axis] for places in offsets.homes.values()]

    def _index_of(self, number):
        """Return the index of line `number` of the file, or of the next one that is sent. Raises Failure if the file ends before it."""
        for index, (known, _) in enumerate(self._lines):
            if known >= number:
                return index
        raise Failure("the file ends before line {}", number)

    def check(self):
        """Raise RefusedLine at the first line that the parser refuses. `$` lines are passed over."""
        for command in (made for at, row in enumerate(self._lines) if row[1][:1] != b"$" for made in self._interpret_line(at)):
            self._board.target = self._board.target if command.target is None else list(command.target)

    # --- replaying

    def _interpret_line(self, index):
        """Return the commands of the line at an index, by the firmware's parser. Raises RefusedLine if that refuses it, Failure at a $ line."""
        number, line = self._lines[index]
        if line.startswith(b"$"):
            raise Failure("line {}, {}: a $ line cannot be replayed; begin behind it", number, line.decode("ascii", "replace"))
        error = errors.LINE_TOO_LONG if len(line) > longest_line(line) else self._gcode.interpret_line(line)
        if error:
            raise RefusedLine("line {}, {}: {}", number, line, error)
        return list(commands_of(self._gcode.commands))

    def _carry_out(self, index):
        """Follow the line at an index: the target, and the highest position of the tool's axis, in steps. Raises Failure if it probes; as
        _interpret_line()."""
        for command in self._interpret_line(index):
            if command.kind == commands.PROBE:
                raise Failure("line {} probes: where it touched is not known; begin before it", self._lines[index][0])
            if command.target is not None:
                self._board.target = list(command.target)
                if len(command.target) > TOOL_AXIS:
                    self._highest = max(command.target[TOOL_AXIS], self._highest or command.target[TOOL_AXIS])

    def _single_motion(self, index):
        """Return the only motion of a line, a line or an arc of one turn at most; None for all others."""
        made = [command for command in self._interpret_line(index) if command.target is not None]
        if len(made) != 1 or made[0].kind not in (commands.LINE, commands.ARC):
            return None
        return made[0] if made[0].kind == commands.LINE or made[0].turns == 1 else None

    def _on_path(self, motion, start, place):
        """True if `place` lies on a motion from `start`, all in steps, within _NEAR_STEPS: on the line, or on the arc's circle."""
        if motion.kind == commands.ARC:
            first, second = motion.first, motion.second
            scale = [self._machine.steps_per_mm[axis] for axis in (first, second)]
            spokes = []
            for point in (start, place):
                spokes.append([(point[axis] - start[axis] - by) / unit
                               for axis, by, unit in zip((first, second), motion.centre, scale)])  # fmt: skip
            radii = [(x * x + y * y) ** 0.5 for x, y in spokes]
            return abs(radii[0] - radii[1]) <= _NEAR_STEPS / min(scale)
        long = max(range(len(start)), key=lambda axis: abs(motion.target[axis] - start[axis]))
        span = motion.target[long] - start[long]
        if not span:
            return False
        share = (place[long] - start[long]) / span
        if not 0 <= share <= 1:
            return False
        return all(
            abs(start[axis] + share * (motion.target[axis] - start[axis]) - place[axis]) <= _NEAR_STEPS for axis in range(len(start))
        )

    # --- what is sent

    def _steps_mm(self, steps, axis):
        return steps[axis] / self._machine.steps_per_mm[axis]

    def _axis_words(self, steps, axes=None):
        return "".join(f"{AXES[axis]}{self._steps_mm(steps, axis):.5f}" for axis in (axes if axes is not None else range(len(steps))))

    def _position_text(self, place):
        return self._axis_words(place) + " mm"

    def _feed_words(self, motion):
        if motion.per_min:
            return f"G93F{motion.per_min / 1000:.3f}"
        return f"G94F{motion.feed * 60 / NM:.4f}"

    def _remaining_lines(self, motion, start, place):
        """Return the lines that lead from `place` to the end of `motion`, absolute and in millimetres; the last moves."""
        if motion.kind == commands.LINE:
            if not motion.feed and not motion.per_min:
                return ["G90G21", f"G53G0{self._axis_words(motion.target)}"]
            if motion.per_min:  # the rest of the minute's part
                long = max(range(len(start)), key=lambda axis: abs(motion.target[axis] - start[axis]))
                left = (motion.target[long] - place[long]) / (motion.target[long] - start[long])
                return ["G90G21G93", f"G53G1{self._axis_words(motion.target)}F{motion.per_min / 1000 / left:.3f}"]
            return [f"G90G21{self._feed_words(motion)}", f"G53G1{self._axis_words(motion.target)}"]
        if motion.per_min:
            raise Failure("an arc in G93 cannot be gone on with amid its way; begin at its line with --from")
        centre = [start[axis] + by - place[axis] for axis, by in zip((motion.first, motion.second), motion.centre)]
        letters = "IJK"
        ways = "".join(f"{letters[axis]}{by / self._machine.steps_per_mm[axis]:.5f}"
                       for axis, by in zip((motion.first, motion.second), centre))  # fmt: skip
        ends = "".join(
            f"{AXES[axis]}{self._steps_mm(motion.target, axis) - self._offsets.offset_of(self._gcode.system, axis) / NM:.5f}"
            for axis in range(min(len(place), 3))
        )
        plane = {(0, 1): 17, (2, 0): 18, (1, 2): 19}[motion.first, motion.second]
        return [f"G90G21G{plane}{self._feed_words(motion)}", f"G{2 if motion.clockwise else 3}{ends}{ways}"]

    def _dots_left(self, motion, start, place):
        """Return the lines that burn the rest of a row of dots: of the dot under way, then of the others, several a line."""
        if motion.per_min:
            raise Failure("a row of dots in G93 cannot be gone on with amid its way; begin at its line with --from")
        long = max(range(len(start)), key=lambda axis: abs(motion.target[axis] - start[axis]))
        span = motion.target[long] - start[long]
        from passo.options.spindle_pwm.steps_viper import end_of  # here: few programs have rows of dots

        row = self._gcode.words.row
        values = [level * self._gcode.max_rpm / 1_000_000 for level in row] if self._gcode.words.packed else [value / 1000 for value in row]
        powers = [f"{value:.3f}".rstrip("0").rstrip(".") for value in values]
        ends = [end_of(dot, len(powers), abs(span)) for dot in range(len(powers))]
        begun = sum(end <= abs(place[long] - start[long]) for end in ends)
        self.dot = begun + 1, len(powers)
        lines, before = [], list(place)
        for first, behind in itertools.pairwise([begun, *range(begun + 1, len(powers), _DOTS_A_LINE), len(powers)]):
            end = [at + round((to - at) * ends[behind - 1] / abs(span)) for at, to in zip(start, motion.target)]
            if end != before:
                lines.append(f"G53G1{self._axis_words(end)}S{':'.join(powers[first:behind])}")
                before = end
        return lines

    def _build_stages(self, place, remainder):
        """Return [(what, lines)] that bring the machine into the state that holds now, at `place`."""
        gcode, machine = self._gcode, self._machine
        gcode.leave_batch()
        self.held = self._state_at_line(place)
        depth = len(place) > TOOL_AXIS and not machine.laser
        stages = [(OFFSETS, self._offset_lines())]
        if depth:
            stages.append((UP, [f"G53G0Z{self._clear_height():.5f}"]))
        stages.append((OVER, [f"G53G0{exact_words(self._board, self._gcode.position, place, (0, 1, 3) if len(place) > 3 else (0, 1)[: len(place)])}"]))
        shift = self._shift_lines(place)
        outputs = [] if machine.laser else self._spindle_lines()
        if gcode.tool:
            outputs.insert(0, f"T{gcode.tool}")
        stages.append((OUTPUTS, outputs + self._coolant_lines()))
        down = []
        if depth:
            down.append(f"G53G0Z{min(self._steps_mm(place, 2) + _CLEARANCE_MM, self._clear_height()):.5f}")
            feed = min(gcode.feed * 60 / NM or _PLUNGE_MM_MIN, _PLUNGE_MM_MIN)
            down.append(f"G94G53G1{exact_words(self._board, self._gcode.position, place, (2,))}F{feed:.1f}")
        elif len(place) > TOOL_AXIS:
            down.append(f"G53G0Z{self._steps_mm(place, 2):.5f}")
        stages.append((DOWN, down + shift))
        laser = ["G0", *self._spindle_lines()] if machine.laser else []
        stages.append((GO, laser + (remainder or []) + self._mode_lines()))
        return [(what, lines) for what, lines in stages if lines]

    def _state_at_line(self, place):
        """Return the program's state for a page: lengths in mm of the work, the feed in mm/min."""
        gcode = self._gcode
        work = [round(self._steps_mm(place, axis) - self._offsets.offset_of(gcode.system, axis) / NM, 3) for axis in range(len(place))]
        return {
            "place": work, "system": f"G{54 + gcode.system}", "tool": gcode.tool, "spindle": gcode.spindle, "rpm": round(gcode.rpm / 1000),
            "coolant": gcode.coolant, "feed": round(gcode.feed * 60 / NM) if gcode.per_minute else 0, "inches": bool(gcode.inches),
            "absolute": bool(gcode.absolute), "laser": bool(self._machine.laser),
        }  # fmt: skip

    def _clear_height(self):
        """Return the height at which the tool is clear of everything, in mm."""
        if self._machine.homes:
            return self._machine.top_mm
        return (self._highest or 0) / self._machine.steps_per_mm[TOOL_AXIS] + _CLEARANCE_MM

    def _offset_lines(self):
        """Return the lines that reset the modes, choose the work system, and set the work offsets that differ from the machine's, and the tool's
        length; in mm."""
        lines = ["G90G21G94G17G40G49M5M9", f"G{54 + self._gcode.system}", "G92.1"]
        for system in range(SYSTEMS):
            kept = [round(place * NM) for place in self._machine.systems.get(f"G{54 + system}", [0] * self._gcode.axes)]
            if kept[: self._gcode.axes] != list(self._offsets.systems[system]):
                places = "".join(f"{AXES[axis]}{place / NM:.5f}" for axis, place in enumerate(self._offsets.systems[system]))
                lines.append(f"G10L2P{system + 1}{places}")
        if self._offsets.tool:
            lines.append(f"G43.1Z{self._offsets.tool / NM:.5f}")
        return lines

    def _shift_lines(self, place):
        """Return the G92 that makes the offset of the program hold at `place` (steps), in mm; none if there is no such offset."""
        if not any(self._offsets.shift):
            return []
        words = "".join(
            f"{AXES[axis]}{self._steps_mm(place, axis) - self._offsets.offset_of(self._gcode.system, axis) / NM:.5f}" for axis in range(len(place))
        )
        return [f"G92{words}"]

    def _spindle_lines(self):
        gcode = self._gcode
        return [f"M{gcode.spindle}S{gcode.rpm / 1000:.3f}"] if gcode.spindle != 5 else [f"S{gcode.rpm / 1000:.3f}"] if gcode.rpm else []

    def _coolant_lines(self):
        return [f"M{code}" for bit, code in ((1, 8), (2, 7)) if self._gcode.coolant & bit]

    def _mode_lines(self):
        """Return two lines that set units, G90 or G91, plane, G98 or G99, the kind of feed, and the motion's code with the feed in the program's unit
        a minute."""
        gcode = self._gcode
        words = f"G{20 if gcode.inches else 21}G{90 if gcode.absolute else 91}G{gcode.plane}"
        words += f"G{98 if gcode.initial else 99}"
        feed = ""
        if gcode.per_minute:
            unit = 25.4 if gcode.inches else 1
            feed = f"F{gcode.feed * 60 / NM / unit:.5f}"
        words += f"G{94 if gcode.per_minute else 93}"
        motion = 80 if self._mode_needs_motion() else gcode.motion // 100
        return [words, f"G{motion}{feed}"]

    def _mode_needs_motion(self):
        """True if the mode of motion cannot be set by a line that does not move."""
        gcode = self._gcode
        return gcode.motion not in (0, 100, 8000) or gcode.motion == 100 and not (gcode.per_minute and gcode.feed)

    def _remaining_rows(self, at):
        """Return the lines from index `at` on. The first that relies on a mode which no line without axis words can restore gets that mode's word."""
        rest = self._lines[at:]
        mode = self._gcode.motion
        if not self._mode_needs_motion():
            return rest
        rest = list(rest)
        for index, (number, line) in enumerate(rest):
            if line.startswith(b"$") or self._gcode.interpret_line(line):
                break
            if self._gcode._found[MOTION] != NONE:
                break
            if [command for command in self._gcode.commands if command.target is not None]:
                rest[index] = number, b"G%d" % (mode // 100) + (self._cycle_words(mode, line) if CODES[mode] & CYCLE else b"") + line
                break
        return rest

    def _cycle_words(self, mode, line):
        """Return the words of a canned cycle that `line` leaves to those before it."""
        gcode = self._gcode
        _, _, above, bottom, dwell, peck = gcode.cycle
        unit = 25.4 * NM if gcode.inches else NM
        words = {"R": above / unit, "Z": bottom / unit}
        if mode in (G73, G83):
            words["Q"] = peck / unit
        if mode == G82:
            words["P"] = dwell / 1_000_000
        return "".join(f"{letter}{value:.5f}" for letter, value in words.items() if letter.encode() not in line.upper()).encode()
