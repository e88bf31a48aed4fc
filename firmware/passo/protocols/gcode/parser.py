"""G-code as grbl 1.1 understands it: one line in, modal state and commands out.

    gcode = GCode("xyz", offsets, machine)
    error = gcode.interpret_line(b"G1 X10 F600") # 0: everything was right, and gcode.commands says what to do
    gcode.commands                              # a list that the next line overwrites, its commands too
    gcode.open_rows(batch), gcode.fields        # for parse_viper.parse(): much faster, for lines that are nothing but a G0 or G1

A line is parsed whole and checked whole before anything of it counts; one that is refused changes nothing. Order of execution is that of
RS274/NGC (NIST IR 6556, table 8). Lengths are nanometres, speeds nanometres a second, both exact for a line in millimetres, or in inches to
five decimals. `machine` has `target`, where the queue will end in steps, and `steps_per_m` of each axis: whatever moved the machine
meanwhile, the next line starts from there. Its `arcs` knows the geometry of arcs (control.arcs).

Extensions: G73, G81, G82 and G83, G43 with a table of tools, and an arc's sweep angle in degrees, H, in place of its end: `G3 I-5 J0 H90`,
with the third axis a helix; more than 360 are more than one turn. The end comes from the machine's CORDIC.
"""

from array import array

from micropython import const

from passo import commands, errors
from passo.commands import Command, thousandths
from passo.protocols.gcode.codes import (
    CODES, COOLING, CYCLE, DISTANCE, FEED_MODE, G80, GROUPS, MOTION, NON_MODAL, PATH, PLANE, RETURN, STOPPING, SYSTEM,
    TOOL_CHANGE, TOOL_LENGTH, TURNING, UNITS,
)
from passo.protocols.gcode.motion import MAX_STEPS, NO_CYCLE, Motions, new_moves
from passo.protocols.gcode.parse_viper import accept_line
from passo.protocols.gcode.reader import MAX_LINE, MAX_TOOL, NONE, Refused
from passo.protocols.gcode.words import F, M_CODES, N, S, T, round_half_away
from passo.protocols.gcode.parse_records import *
from passo.records import BIAS, FARTHEST, FASTEST_NM_S, NM_PER_M

# `fields`, what plain lines are understood by; three numbers each where they are the axes'.
_ANY = const(0)
_SAME = const(1)
_OTHER = const(2000)  # no power
_FARTHEST_NM = const(0x7FFFFFFF)  # of a plain line
_MOST_RPM = const(100_000_000)
_ROUNDING = const(0x18000)  # P and Q: of G64 how far corners may be rounded; the path is kept to


class GCode(Motions):
    at_end = None  # an option's: at_end(gcode) appends the motion by which M2 and M30 begin

    def __init__(self, axes, offsets, machine):
        """`axes`: the names of the machine's axes in their order, the first of "xyza"."""
        Motions.__init__(self, len(axes), offsets, machine)
        self.ended = False  # the line was the programme's last
        self.changer = None  # an option's, which makes M6 several commands
        self.fields = array("i", [0] * PARSE_FIELDS)  # for plain lines
        self.fields[PARSE_AXES] = len(axes)
        self._ends = memoryview(self.fields)[PARSE_TARGET : PARSE_TARGET + len(axes)]
        # The state for which _know_axes() has filled them in: this coordinate system (None: for none), version of the offsets, and travel.
        self._system_known = None
        self._offsets_known = 0
        self._reach = None
        self._level = 0  # power of the modal state, thousandths
        self._unknown = True  # `fields` does not say where it is
        self.reset()

    def reset(self):
        """Set the modal state as after power-up. Work offsets stay."""
        self.leave_batch()
        self.motion = 0
        self.plane = 17
        self.inches = self.inch_feed = False  # the second: F was given in G20
        self.absolute = self.per_minute = self.initial = True  # G90, G94, G98
        self.feed = self.rpm = self.system = self.coolant = self.tool = self.number = 0
        self.spindle = 5
        self.cycle = NO_CYCLE
        self._steps = [None] * self.axes

    def forget_position(self):
        """Take the position from the machine at the next line: after a change of steps/mm, too."""
        self.leave_batch()
        self._steps = [None] * self.axes
        self._system_known = None

    def leave_batch(self):
        """Take over the changes of the last plain lines; the next batch finds out its position anew."""
        if not self._unknown:
            self._unknown = True
            fields = self.fields
            fields[PARSE_KNOWN] += 1
            self.feed = fields[PARSE_FEED]
            self.rpm = fields[PARSE_RPM]
            self.number = fields[PARSE_NUMBER]
            self.ended = False
            self.motion = fields[PARSE_MODAL] * 100
            self._steps = list(self._ends)
            named = fields[PARSE_NAMED]
            self.position[:named] = list(fields[PARSE_POSITION : PARSE_POSITION + named])

    def interpret_line(self, line, jog=False):
        """Read a line, bytes. Returns 0, or the number of the error that refuses it; `commands` is empty then. `jog`: the line follows `$J=`."""
        self.leave_batch()
        self.commands = []
        self.ended = False
        error = self.words.scan_line(line)
        if error:
            return error
        self._take_position()
        try:
            self._find_codes()
            if jog:
                self._read_jog()
            else:
                self._read_line()
        except Refused as refusal:
            self.commands = []
            if self._length_before is not None:
                self.offsets.tool = self._length_before
                self._length_before = None
            return refusal.args[0]
        return 0

    # --- batches of plain lines

    def open_rows(self, batch):
        """Return True if plain lines may be put into `batch`, which the controller has just opened."""
        if (
            self._unknown or self.offsets.version != self._offsets_known or self._ends != batch.target
            or self._reach is not batch.reach
        ) and not self._fill_fields(batch):  # fmt: skip
            return False
        fields = self.fields
        dynamic = self._dynamic
        if fields[PARSE_FULL] <= _SAME and (self._lit != batch.tool or dynamic != batch.dynamic or self._level != batch.power):
            return False  # above _SAME each line brings its own tool and power
        fields[PARSE_LIT] = 1 if batch.tool else 0
        fields[PARSE_POWER] = batch.power if batch.dynamic == dynamic else _OTHER
        fields[PARSE_DYNAMIC] = 1 if dynamic else 0
        return True

    def _fill_fields(self, batch):
        """Fill in `fields` from the modal state. Returns False if that is not for plain lines."""
        self.leave_batch()
        if (
            self.motion not in (0, 100, 200, 300) or not self.per_minute or self.turns and self.inch_feed != self.inches
            or self.feed > FASTEST_NM_S or self.rpm > FARTHEST
            or self.laser and (not _SAME < self.max_rpm <= _MOST_RPM or batch.slow_tool)
        ):  # fmt: skip
            return False
        self._take_position()
        fields = self.fields
        if (
            self.system != self._system_known or self.offsets.version != self._offsets_known or self._reach is not batch.reach
        ) and not self._know_axes(batch.reach):  # fmt: skip
            return False
        positions = self.position
        for axis in range(fields[PARSE_NAMED]):
            if abs(positions[axis]) > _FARTHEST_NM:
                return False
            fields[PARSE_POSITION + axis] = positions[axis]
        self._ends[:] = batch.target
        fields[PARSE_RELATIVE] = 0 if self.absolute else 1
        fields[PARSE_INCHES] = 1 if self.inches else 0
        fields[PARSE_MODAL] = self.motion // 100
        fields[PARSE_ARCS] = 1 if self.plane == 17 and self.axes > 1 and self.machine.arcs is not None else 0
        fields[PARSE_FEED] = self.feed
        fields[PARSE_NUMBER] = self.number
        fields[PARSE_RPM] = self.rpm
        fields[PARSE_FULL] = _ANY if self.spindle == 5 else self.max_rpm if self.laser else _SAME
        self._set_shared(self.motion, self.feed, 0, 0, self.spindle, self.rpm)
        self._level = thousandths(self._power)
        self._unknown = False
        fields[PARSE_KNOWN] += 1
        return True

    def _know_axes(self, reach):
        """Fill in offsets, steps/mm and travel, which stay if a line changes modes only. Returns False if they are too large for plain lines."""
        fields = self.fields
        self._system_known = None
        fields[PARSE_LEAST] = 1
        fields[PARSE_NAMED] = 3 if self.turns else self.axes  # degrees are for the full parser
        for axis in range(self.axes):
            resolution = self.machine.steps_per_m[axis]
            if axis < fields[PARSE_NAMED]:
                offset = self.offsets.offset_of(self.system, axis)
                if abs(offset) > _FARTHEST_NM or resolution > FARTHEST:
                    return False
                fields[PARSE_OFFSET + axis] = offset
            fields[PARSE_RESOLUTION + axis] = resolution
            fields[PARSE_LEAST] += 25_000_000 // resolution
            fields[PARSE_LOW + axis] = BIAS + (-FARTHEST if reach is None else max(reach[0][axis], -FARTHEST))
            fields[PARSE_HIGH + axis] = BIAS + (FARTHEST if reach is None else min(reach[1][axis], FARTHEST))
        self._reach = reach
        self._offsets_known = self.offsets.version
        self._system_known = self.system
        return True

    def take_arc(self, batch):
        """Have the machine take the arc that parse() has come to, `batch` being open. False if it has to come as a command: to wait, or
        to be refused."""
        fields = self.fields
        arcs = self.machine.arcs
        x, y = fields[PARSE_TO] - fields[PARSE_POSITION], fields[PARSE_TO + 1] - fields[PARSE_POSITION + 1]
        i, j = fields[PARSE_I], fields[PARSE_J]
        if arcs.check_centre(x, y, i, j):
            return False
        command = self._moves[0]
        command.kind = commands.ARC
        command.target = [fields[PARSE_TARGET + axis] + fields[PARSE_DELTAS + axis] for axis in range(self.axes)]
        command.feed = fields[PARSE_SPEED]
        command.per_min = 0
        command.number = fields[PARSE_LINE]
        command.tool = fields[PARSE_LIT] > 0
        command.dynamic = fields[PARSE_DYNAMIC] > 0
        command.first, command.second, command.turns = 0, 1, 1
        command.clockwise = fields[PARSE_MOTION] == 2
        command.over_half = arcs.over_half(x, y, i, j, command.clockwise)
        i = round_half_away((fields[PARSE_POSITION] + i) * fields[PARSE_RESOLUTION], NM_PER_M)
        j = round_half_away((fields[PARSE_POSITION + 1] + j) * fields[PARSE_RESOLUTION + 1], NM_PER_M)
        command.centre = i - fields[PARSE_TARGET], j - fields[PARSE_TARGET + 1]
        if max(abs(i), abs(j)) > MAX_STEPS or not batch.arc(batch, command, fields[PARSE_POWER]):
            return False
        accept_line(fields, batch.rows, 0)
        return True

    def _read_line(self):
        """Read the words of a line, check them all, then let them count. Raises Refused."""
        found = self._found
        number = self._read_count(N, 0, MAX_LINE, errors.LINE_NUMBER)
        non_modal = found[NON_MODAL]
        motion = self.motion if found[MOTION] == NONE else found[MOTION]
        self._inches = self.inches if found[UNITS] == NONE else found[UNITS] == 2000
        self._absolute = self.absolute if found[DISTANCE] == NONE else found[DISTANCE] == 9000
        self._plane = self.plane if found[PLANE] == NONE else found[PLANE] // 100
        self._system = self.system if found[SYSTEM] == NONE else found[SYSTEM] // 100 - 54
        self._initial = self.initial if found[RETURN] == NONE else found[RETURN] == 9800
        axis_words = self._left & self._axis_mask | self._flat
        moves = found[MOTION] not in (NONE, G80) or (not self._axis_command and (axis_words or self._gives_sweep(motion)))
        per_minute = self.per_minute if found[FEED_MODE] == NONE else found[FEED_MODE] == 9400
        feed, per_min = self._read_feed(per_minute, moves and motion not in (0, G80))
        rpm = self.words.word_value(S, 3) if self._take_word(S) and not self.words.packed else self.rpm
        tool = self._read_count(T, self.tool, MAX_TOOL, errors.TOOL_NUMBER)
        spindle = self.spindle if found[TURNING] == NONE else (found[TURNING] - M_CODES) // 100
        coolant = self._read_coolant(found[COOLING])
        dwell = self._read_dwell() if non_modal == 400 else None
        handed_on = [self._hand_on(code) for code in self._on]
        self._set_shared(0 if non_modal in (2800, 3000) else motion, feed, per_min, number, spindle, rpm)
        self._cycle = self.cycle
        offsets = target = None
        if found[TOOL_LENGTH] != NONE:
            offsets = self.offsets.set_tool, self._read_length(found[TOOL_LENGTH], tool)
        elif non_modal in (1000, 2810, 3010, 9200, 9210):
            offsets = self._read_offsets(non_modal, axis_words)
        if non_modal == 5300 and motion not in (0, 100):
            raise Refused(errors.MACHINE_COORDINATES)
        if non_modal in (2800, 3000):
            target = self._go_home(non_modal // 100, axis_words)
        elif moves:
            target = self._read_motion(motion, axis_words, non_modal == 5300)
        self._check_rest(motion)
        if self.words.row:
            self._add_row(target and self._cutting and motion == 100, spindle)

        # Everything is right: from here on it counts. The motion's commands are there already; commands before it are put
        # before them.
        before = self._goes_before(spindle, rpm, motion, moves, tool, coolant, dwell, handed_on)
        if len(self.commands) > 1 and moves:
            self.commands[0].also = self.commands[1:]
            self._moves = new_moves()  # these may be looked at until the last has begun
        if target:
            self.position, self._steps = target, self.commands[-1].target
        if moves and CODES[motion] & CYCLE:
            self.commands[1:] = [Command(commands.MORE, value=self._drilling)]
        if before:
            self.commands = before + self.commands
        if offsets:
            offsets[0](*offsets[1:])
            self._length_before = None
        self.number = number
        self.motion, self.plane, self.inches, self.absolute = motion, self._plane, self._inches, self._absolute
        self.per_minute, self.feed, self.rpm, self.tool = per_minute, feed if per_minute else 0, rpm, tool
        self.spindle, self.coolant, self.system = spindle, coolant, self._system
        self.initial, self.cycle, self.inch_feed = self._initial, self._cycle, self._inch_feed
        if found[STOPPING] != NONE:
            self._stop_programme(found[STOPPING] - M_CODES)

    def _check_rest(self, motion):
        """Raise Refused for words that nothing has taken."""
        if self._left & ~_ROUNDING or self._left and self._found[PATH] != 6400:
            unused = motion == G80 and self._left & self._axis_mask
            raise Refused(errors.AXIS_WORDS_UNUSED if unused else errors.WORDS_UNUSED)

    def _add_row(self, cuts, spindle):
        """Give the motion the line's row of dots; `cuts`: it is a G1. Raises Refused."""
        if not cuts or len(self.commands) > 1:
            raise Refused(errors.WORDS_UNUSED)
        if spindle == 5:
            return
        if not self.laser:
            raise Refused(errors.UNSUPPORTED)
        command = self.commands[0]
        if self.words.packed:
            command.dots = self.words.row
            last = 1000 * command.dots[-1]
        else:
            powers = [min(rpm * 1_000_000 // self.max_rpm, 1_000_000) for rpm in self.words.row]
            last = powers[-1]
            command.dots = [thousandths(power) for power in powers]
        command.tool, command.power = last > 0, last
        self._moves = new_moves()

    def _goes_before(self, spindle, rpm, motion, moves, tool, coolant, dwell, handed_on):
        """Return the commands of the line that are carried out before its motion. Raises Refused."""
        before = []
        turned = spindle != self.spindle or rpm != self.rpm and spindle != 5
        if self.laser and spindle == 3 and not self.commands and (self.motion in (100, 200, 300)) != self._cutting:
            turned = True  # M3 burns at a stand too, while G1, G2 or G3 holds
        line = self._cutting or moves and motion == 0
        change = self._found[TOOL_CHANGE] != NONE
        if change and self.changer:
            change = self.changer.append_change(self, before, tool, spindle, rpm, coolant)
        if change is not None and turned and not (self.laser and line and self.commands and spindle == self.spindle):
            before.append(self._spindle_command(spindle, rpm, motion))
        if change:
            before.append(Command(commands.PAUSE, value=1 + tool))
        if change is not None and coolant != self.coolant:
            before.append(Command(commands.COOLANT, value=coolant))
        before += handed_on
        if dwell is not None:
            before.append(Command(commands.DWELL, value=dwell))
        return before

    def _read_jog(self):
        """Read the words of a line behind `$J=`. Raises Refused."""
        found = self._found
        for group in range(GROUPS):
            if found[group] != NONE and group not in (NON_MODAL, DISTANCE, UNITS):
                raise Refused(errors.JOG_WORDS)
        if found[NON_MODAL] not in (NONE, 5300):
            raise Refused(errors.JOG_WORDS)
        number = self._read_count(N, 0, MAX_LINE, errors.LINE_NUMBER)
        axis_words = self._left & self._axis_mask
        if not axis_words:
            raise Refused(errors.NO_AXIS_WORDS)
        self._inches = self.inches if found[UNITS] == NONE else found[UNITS] == 2000
        self._absolute = self.absolute if found[DISTANCE] == NONE else found[DISTANCE] == 9000
        self._system = self.system
        feed = round_half_away(self._length_of(F), 60) if self._take_word(F) else 0
        if not feed:
            raise Refused(errors.NO_FEED)
        self._set_shared(0, feed, 0, number, self.spindle, self.rpm)
        target = self._read_target(found[NON_MODAL] == 5300)
        if self.turns and self._inches:
            feed = self._angular_feed(target, feed)
        if self._left:
            raise Refused(errors.WORDS_UNUSED)
        self._go_to(commands.JOG_TO, target, feed)

    def jog_to(self, lengths, feed, counted):
        """A jog that was no line, in `commands`: to {axis: nanometres} at `feed`. `counted`: from where it counts, as G53 machine
        coordinates, as G54 those of work, as G91 from here. 0, or the error that refuses it."""
        self.leave_batch()
        self._take_position()
        self.commands = []
        self._set_shared(0, feed, 0, self.number, self.spindle, self.rpm)
        target = self.position[:]
        for axis in lengths:
            before = target[axis] if counted == 91 else 0 if counted == 53 else self.offsets.offset_of(self.system, axis)
            target[axis] = before + lengths[axis]
        try:
            command = self._fill_motion(self._moves[0], target, feed)
        except Refused as refusal:
            return refusal.args[0]
        command.kind = commands.JOG_TO
        self.commands = [command]
        self.position, self._steps = target, command.target
        return 0

    # --- the rest of a line

    def add_rapid(self, target):
        """Append a rapid motion to `target`, nm, with the tool as it is: for an option. Raises Refused."""
        self._set_shared(0, 0, 0, self.number, self.spindle, self.rpm)
        self._go_to(commands.LINE, target, 0)

    def _spindle_command(self, spindle, rpm, motion):
        """Return the command SPINDLE: `spindle` 3, 4 or 5, `rpm` in thousandths."""
        command = Command(commands.SPINDLE, value=spindle)
        lit = spindle != 5 and rpm > 0
        command.power = min(rpm * 1_000_000 // self.max_rpm, 1_000_000) if lit else 0
        command.tool = lit and not (self.laser and (spindle == 4 or motion not in (100, 200, 300)))
        return command

    def _stop_programme(self, code):
        """M0, M1, M2, M30."""
        if code in (0, 100):
            self.commands.append(Command(commands.PAUSE))
            return
        if self.at_end:
            self.at_end(self)
        self.motion = 100  # from here on M2 and M30 restore the modal state
        self.plane = 17
        self.absolute = self.per_minute = self.initial = self.ended = True
        self.system = self.coolant = 0
        self.spindle = 5
        overrides = Command(commands.OVERRIDE, value=commands.ALL)
        overrides.power = 100
        coolant = Command(commands.COOLANT)
        coolant.ends = True
        self.commands += [Command(commands.SPINDLE, value=5), coolant, overrides, Command(commands.SYNC)]
