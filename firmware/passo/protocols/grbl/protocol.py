"""The language of grbl 1.1 on one link: lines in, one `ok` or `error:N` a line out, in order.

    grbl = Grbl("xyz", offsets, machine, batch, most)
    for command in grbl.feed(serial.read(), now_ms):    # a generator: it goes on where reply() has left it
        ... event ...
        serial.write(grbl.reply(event))                 # before the next command is asked for
    serial.write(grbl.push_bytes(event))             # what the machine says unasked

Real-time bytes are taken out as they come and never wait. Of everything else one command is under way at a time: the
next line is not looked at before the one before it is answered, so each is understood in the state its forerunner left.

    bytes ─► _peel ─► Lines ─► GCode or System ─► commands ─► controller ─► events ─► reply
                └────► real-time commands ───────────────────────▲

Lines that are nothing but a G0 or G1, or an arc about I and J, go several at a time, in a batch, while nothing is unusual: take_batch(), before feed() has the
rest. They are answered when they are queued.

A sender may have 512 bytes under way. Lines beyond that are kept too while there is room; a line that found none is
answered by error:11 and nothing of it is done.
"""

import gc

import micropython
from micropython import const

from passo import commands, errors
from passo.commands import ACCEPTED, ALARM, DROPPED, NOTICE, REFUSED, RESTARTED, Command, Event
from passo.protocols import HELLO_WIRE
from passo.protocols.grbl import report as grbl_report
from passo.protocols.gcode.parser import GCode
from passo.protocols.gcode.parse_records import *
from passo.protocols.gcode.words import LONGEST, bare_line, longest_line, round_half_away
from passo.protocols.grbl.lines import ARC, LEFT, LONG, REAL_TIME, RX_BYTES, SLOWLY, ODD, Lines, buffer_bytes, mark_of, plain_text, real_time, what_acted
from passo.protocols.grbl.report import Status
from passo.protocols.grbl.system import System, text_answer
from passo.records import BATCH_ROWS, NM_PER_M, SETTING_LASER, SETTING_MAX_RPM, TRACE_TAKEN

gc.collect()
try:
    from passo.protocols.grbl.take_viper import take_lines
except MemoryError:  # a board that has too little, or not in one piece: feed() deals with all lines
    take_lines = None

_SEVERAL = const(2)
_DOLLAR = const(36)
_ALARMS = const(200)  # errors.py has alarms that much higher

_OKS = tuple([b"ok\r\n" * count for count in range(BATCH_ROWS + 1)])


class Grbl:
    keeps = True  # see app.py
    notices = {}  # by number of a notice: a function that returns its text for a value; an option replaces the whole
    raw = b"$"  # lines that begin with these bytes keep small letters and blanks; an option sets it
    dots = None  # read_dots() of an option, for rows of them in plain lines
    stored = None  # (limits, frame, units, answers) of an option that feeds a file to this link: options/jobs/language_grbl.py

    def __init__(self, axes, offsets, machine, batch, most):
        """`axes`: names; `machine`: the record of its state; `batch`: a batch.Lines of the link; `most`: lines that feed() takes."""
        self.gcode = GCode(axes, offsets, machine)
        self.batch = batch
        self._settings = settings = machine.settings
        self._machine = machine
        self._number, self._most = batch.link, most
        self.system = System(self.gcode, settings, machine, batch)
        self._status = Status(self.gcode, settings, machine)
        self._lines = lines = Lines()
        self.prepare, self.drop_begun, self.space = lines.make_buffer, lines.drop_begun, lines.free_bytes
        self._taker = self._arrays = None  # the batch's, and take_lines()' arguments
        asked = Command(commands.STATUS)  # the command of `?`, used again and again
        asked.reply = Event(ACCEPTED, asked)
        self._asked = (asked,)
        self._marked = False  # lines that are kept may have marks of real-time bytes
        self._last = 0  # the last byte of the last data with real-time bytes
        self._stale = 0  # lines sent before an alarm, a stop or a hand-over
        self._why = 0  # the error that answers them
        self._stored = False  # it reads a file, in which no byte acts at once
        self._told = {}  # functions of options, by the kind of their command
        self._take_settings()
        self._forget_lines()

    def learn_lines(self, start, kind, understand, answer_text, asked=False):
        """Take an option's `$` lines, as System.learn_lines() does. Their commands are of `kind`; answer_text(event.value) is the answer before `ok`."""
        self._told[kind] = answer_text
        self.system.marks = start[1] + self.system.marks
        self.system.learn_lines(start, understand, asked)

    def _forget_lines(self):
        """Forget all lines, and the command under way."""
        self._lines.clear_lines()
        self._start_lines = []  # texts, whose turn is before that of the lines
        self._under_way = None  # the command that an answer is awaited for
        self._rest = []  # of its line's commands
        self._start_line = None  # the line under way is a start-up line

    def _take_settings(self):
        """Take laser and highest speed from the settings."""
        settings = self._settings
        self._version = settings.version
        laser = bool(settings.value(SETTING_LASER))
        if self.gcode.laser and not laser:
            self.gcode.spindle = 5  # the machine has switched it off: the next motion must not start a spindle
        self.gcode.laser = laser
        self.gcode.max_rpm = settings.value(SETTING_MAX_RPM)
        self.gcode.forget_position()

    # --- bytes to batches

    def sources(self):
        """Return (line buffer, parser), for an option that records this link. Call it before prepare()."""
        return self._lines, self.gcode

    def begin_file(self):
        """Begin a stored job: modal state as after power-up, offsets stay; the bytes kept so far go."""
        self._forget_lines()
        self._stale = 0
        self._stored = True
        self.gcode.reset()

    @micropython.native
    def take_batch(self, data, now_ms):
        """Put `data` into the line buffer. Then queue lines from there, until one is more than a G0 or G1, or the machine takes none.
        Returns an `ok` for each, b"" if there was none. Or commands that have to be carried out before the next call: `?` as a tuple, other
        real-time bytes of `data` as a generator."""
        if not self.batch.begun:
            if data:
                lines = self._lines
                fields = lines.fields
                if not lines.text:
                    lines.make_buffer()
                kept = buffer_bytes(data, len(data), lines.text, fields)
                if kept == REAL_TIME:
                    fields[LINES_WAITS] = 0  # a hold or reset may make room for lines
                    return self._take_real_time(data)
                if kept:
                    lines.finish_buffering(kept, data)
                if fields[LINES_ASKED]:
                    return self.feed(b"", now_ms)  # the answer comes first
                if fields[LINES_AT] == fields[LINES_WHOLE]:
                    return b""  # no line has ended: to open the batch takes 0.7 ms
                data = b""
            if not self._open_batch():
                return b""
        text, lines, fields, rows, dots, read_dots, most, travel, queue_lines, target, blocks, scratch, indices, limits = self._arrays
        taken = take_lines(
            data, len(data), text, lines, fields, rows, dots, read_dots, most, travel, queue_lines, target, blocks, scratch, indices, limits
        )
        return _OKS[taken] if 0 < taken <= BATCH_ROWS else self._answer_lines(taken, data)

    @micropython.native
    def _open_batch(self):
        """Open the batch. Returns True if it is open: nothing is unusual, and the first line kept is no `$` line."""
        lines = self._lines
        fields = lines.fields
        fields[LINES_WAITS] = 0
        if (
            take_lines is None or self._under_way is not None or self._rest or self._start_lines or self._stale
            or self._version != self._settings.version or fields[LINES_AT] == fields[LINES_WHOLE] or lines.text[fields[LINES_AT]] == _DOLLAR
        ):  # fmt: skip
            return False
        batch = self.batch
        if not batch.open(batch):
            return False
        if not self.gcode.open_rows(batch):
            batch.close(batch)
            return False
        if self._taker is not batch.taker:
            lines.make_buffer()
            self._taker = batch.taker
            self._arrays = (lines.text, fields, self.gcode.fields, batch.rows, batch.dots, self.dots, batch.most) + batch.taker
        return True

    def _answer_lines(self, taken, data):
        """Return the answers to take_lines(), and go on if it could not: with a slow buffer, an arc, or lines that the machine has refused."""
        if taken == REAL_TIME:
            return self._take_real_time(data)
        lines = self._lines
        if not taken:
            return self.feed(b"", 0) if lines.fields[LINES_ASKED] else b""
        if taken == SLOWLY or taken == LONG:
            lines.finish_buffering(taken, data)
            return self.take_batch(b"", 0)
        if taken == ARC:
            taken = lines.fields[LINES_TAKEN]
            if self.gcode.take_arc(self.batch):
                lines.fields[LINES_AT] = self.gcode.fields[PARSE_ARC]
                taken += 1
        if taken != LEFT:
            return _OKS[1] * taken
        batch = self.batch
        batch.count = filled = lines.fields[LINES_FILLED]
        before = lines.fields[LINES_TAKEN] - self._taker[0][TRACE_TAKEN]
        count = batch.accept(batch)
        return _OKS[1] * (before + count) + b"error:%d\r\n" % errors.JOG_TRAVEL * (filled - count)

    # --- bytes to commands

    def buffer_input(self, data):
        """Keep `data`. Returns the commands of its real-time bytes, as feed(). Lines wait for take_batch() and feed()."""
        if not self._lines.take_bytes(data):
            return self._take_real_time(data)
        asked = self._lines.fields[LINES_ASKED]
        self._lines.fields[LINES_ASKED] = 0
        return self._asked if asked else ()

    def feed(self, data, now_ms):
        """Return commands, each to be answered by reply() before the next is asked for."""
        if data:
            if not self._lines.take_bytes(data):
                return self._take_real_time(data)  # the lines come with the next cycle, in a batch or not
        else:
            fields = self._lines.fields
            if fields[LINES_ASKED]:
                fields[LINES_ASKED] = 0
                return self._asked
            if self._under_way is not None or fields[LINES_WAITS]:
                return ()
            if fields[LINES_AT] == fields[LINES_WHOLE] and not (self._rest or self._start_lines or self._lines.lost):
                return ()
        return self._next_commands()

    def pending(self):
        """Return True if feed() has something to say without new bytes. A line that found no room waits until several have some."""
        lines = self._lines
        fields = lines.fields
        if fields[LINES_ASKED]:
            return True
        if fields[LINES_WAITS] and self._machine.blocks() < _SEVERAL:
            return False
        return fields[LINES_AT] < fields[LINES_WHOLE] or self._rest or self._start_lines or lines.lost

    def is_amid(self, text):
        """Return True if, behind `text`, a line has begun and not ended."""
        tail = text.replace(b"\r", b"\n").split(b"\n")
        return bool(tail[-1].strip(b"?!~\x18")) or len(tail) == 1 and self._lines.is_amid_line()

    def _next_commands(self):
        """Yield the commands of the oldest lines, `most` at most, as long as each has been answered."""
        if self._lines.fields[LINES_ASKED]:
            self._lines.fields[LINES_ASKED] = 0
            yield self._asked[0]
        most = self._most
        while self._under_way is None and most:
            most -= 1
            if not self._rest:
                # A start-up line as text, or the oldest line, None for one that was too long; it leaves the queue.
                line = self._start_lines.pop(0) if self._start_lines else self._lines.next_line()
                if line is False:
                    return
                self._rest = self._line_commands(line)
            self._under_way = self._rest.pop(0)
            yield self._under_way

    def _take_real_time(self, data):
        """Take the real-time bytes out. Within a line those from 0x80 on leave a mark, and other bytes from there on ODD: letters beyond
        ASCII may be made of both. C2 before 80 … 9F goes with it: CNCjs writes real-time bytes as UTF-8, in which no text has these two."""
        plain = bytearray()
        asked = False
        before = self._last
        for byte in data:
            if before == 0xC2 and 0x80 <= byte <= 0x9F and real_time(byte) and not self._stored:
                if plain:
                    plain = plain[:-1]
                else:
                    self._lines.drop_odd()
            before = byte
            if byte == 0x3F:
                if not asked:
                    asked = True
                    self._lines.fields[LINES_ASKED] = 0
                    yield self._asked[0]
                continue
            command = real_time(byte) if byte > 0x7D or byte < 0x40 else None
            if command is None or self._stored:
                plain.append(byte if byte < 0x80 and command is None else ODD)
            elif command.kind == commands.RESET:
                plain = bytearray()
                self._forget_lines()
                self._stale = 0
                yield command
            else:
                if byte > 0x7F and (plain[-1] not in (10, 13) if plain else self._lines.is_amid_line()):
                    plain.append(mark_of(command))
                    self._marked = True
                yield command
        self._last = before
        if plain:
            self._lines.take_bytes(plain)

    # --- lines to commands

    def _line_commands(self, line):
        """Return the commands of a line, one at least."""
        if self._stale and not isinstance(line, str):
            self._stale -= 1
            if line is None or bare_line(line):
                return [Command(commands.BAD, error=self._why)]
        self.gcode.leave_batch()
        if not self._machine.checking:
            self.gcode.coolant = self._machine.coolant  # real-time bytes change it too
        self._start_line = None
        if self._version != self._settings.version:
            self._take_settings()
        if line is None or len(line) > LONGEST and len(bare_line(line)) > longest_line(bare_line(line)):
            return [Command(commands.BAD, error=errors.LINE_TOO_LONG)]
        if isinstance(line, str):
            self._start_line = line
            line = line.encode()
        if b"\0" in line:
            line = line.replace(HELLO_WIRE, b"")  # this link has no frames
            if b"\0" in line:
                return [Command(commands.BAD, error=errors.LETTER)]
        acted = []
        if self._marked or b"\x7f" in line:  # ODD
            self._marked = bool(self._lines.has_lines() or self._lines.is_amid_line())
            acted = what_acted(line, self._machine)
            acted = text_answer(grbl_report.message_line(grbl_report.LETTERS % acted)) if acted else []
            if b"\x7f" in bare_line(line):
                return acted + [Command(commands.BAD, error=errors.LETTER)]
        if b"$" in line and bare_line(line)[:1] == b"$":
            result = self.system.execute_line(line.decode() if line[:3] == self.raw else plain_text(line))
        elif not line.strip() or line.strip() == b"%":
            result = text_answer("")
        elif self._machine.commander != self._number:
            result = errors.COMMANDED_ELSEWHERE if bare_line(line) else text_answer("")
        elif self._machine.state in ("alarm", "jog", "sleep"):
            result = errors.LOCKED if bare_line(line) else text_answer("")
        else:
            result = self.gcode.interpret_line(line) or self.gcode.commands or text_answer("")
        return acted + ([Command(commands.BAD, error=result)] if isinstance(result, int) else result)

    # --- events to bytes

    def reply(self, event):
        """Return the bytes that tell the sender of `event`."""
        command = event.command
        if command.kind == commands.STATUS:
            fields = self._lines.fields
            room = RX_BYTES - fields[LINES_END] + fields[LINES_AT]
            return self._status.report_bytes(event.value, room if room > 0 else 0)
        if command is not self._under_way or command.kind in (commands.SPINDLE, commands.COOLANT, commands.OVERRIDE):
            self._status.overrides = 0  # a report shows it at once
        if command is not self._under_way:
            return b""
        self._under_way = None
        text = getattr(command, "text", "")
        if event.kind == REFUSED and not self._is_failed_homing(event):
            self._rest = []
            self.gcode.forget_position()
            if command.kind == commands.SPINDLE:
                self.gcode.spindle = 5
            return (text + self._answer_line("error:%d" % event.error)).encode()
        if command.kind == commands.PROBE and event.value:
            text += self._note_probe(event.value, command.measures)
        if command.kind == commands.HOME:
            if event.value:
                from passo.protocols.grbl.homing import homing_lines  # loaded at the start, by check()

                text += homing_lines(event.value)
            self._start_lines = [] if self._machine.alarm else self.system.start_lines()
        if command.kind in self._told and event.value:
            text += self._told[command.kind](event.value)
        if self._rest and self._rest[0].kind == commands.MORE:
            made = next(self._rest[0].value)
            if made is None:
                self._rest.pop(0)
            else:
                self._rest.insert(0, made)
        if not self._rest or self._rest[0].kind == commands.RESET:
            if self.gcode.ended and command.kind == commands.SYNC:
                text += grbl_report.message_line(grbl_report.PROGRAMME_END)
            text += self._answer_line("ok")
        return text.encode()

    def _is_failed_homing(self, event):
        """Return True for homing that an alarm has ended. grbl answers ok then, behind the alarm and before its banner."""
        if event.command.kind != commands.HOME or event.error != errors.LOCKED:
            return False
        return errors.ALARM_HOMING_RESET <= self._machine.alarm <= errors.ALARM_TWO_MOTORS

    def _answer_line(self, text):
        """Return an answer's line, behind the text of a start-up line."""
        if self._start_line is not None:
            text = ">%s:%s" % (self._start_line, text)
        return text + "\r\n"

    def push_bytes(self, event):
        """Return the bytes that the machine sends unasked."""
        if event.kind in (ALARM, DROPPED) and event.error != errors.ALARM_HOMING_REQUIRED:
            self.gcode.leave_batch()
            self.gcode.spindle, self.gcode.coolant = 5, 0  # the machine has switched them off: G1 without M3 must not light the tool
        if event.kind == ALARM:
            return b"ALARM:%d\r\n" % (event.error - _ALARMS) if event.error > _ALARMS else b""
        if event.kind == NOTICE:
            if event.error in self.notices:
                return grbl_report.message_line(self.notices[event.error](event.value)).encode()
            text = grbl_report.NOTICES[event.error]
            return grbl_report.message_line(text if event.value is None else text % event.value).encode()
        if event.kind != RESTARTED:
            return b""
        text = self._begin_anew(event.error)
        if not event.error:
            self._start_lines = self.system.start_lines()
        return text.encode()

    def drop(self, event):
        """Drop all lines that have come so far. A stop from another link is answered as a reset is, so that a sender ends its job; each line
        is answered by an error in an alarm, or if another link has been given the command.
        """
        lines = self._lines
        self._why = event.error
        self._stale = 1 if lines.is_amid_line() else 0
        if event.kind == RESTARTED:  # push_bytes() is to follow
            self._why = errors.STOPPED
        elif event.kind == DROPPED and event.error == errors.STOPPED:
            return self._begin_anew(self._machine.alarm).encode()
        else:
            if event.kind == ALARM:
                self._why = errors.LOCKED
            self._stale += lines.count_lines()
            self._start_lines = []
            if self._rest and self._rest[0].kind != commands.HELLO:
                self._rest = [Command(commands.BAD, error=self._why)]
        return b""

    def _begin_anew(self, alarm):
        """Forget everything. Returns the banner, and the note about an alarm."""
        self._forget_lines()
        self.gcode.reset()
        self.gcode.offsets.reset_shift()
        self._status.offsets = self._status.overrides = 0  # in the next report
        text = ("error:%d\r\n" % errors.MEMORY if self._settings.damaged else "") + grbl_report.BANNER
        if alarm:
            text += grbl_report.message_line(grbl_report.NOTICES[errors.NOTICE_LOCKED])
        return text

    def _note_probe(self, value, measures):
        """Note where the probe has touched; with `measures` that is a tool's length. Returns the [PRB:…] line."""
        position, touched = value
        system = self.system
        system.probed = [round_half_away(steps * NM_PER_M, per_m) for steps, per_m in zip(position, self._machine.steps_per_m)]
        system.touched = touched
        if measures and touched:
            self.gcode.offsets.measure_tool(system.probed[2])
        return grbl_report.probe_line(system.probed, touched, system.in_inches())
