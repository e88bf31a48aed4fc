"""The `$` lines of the grbl language: settings, parameters, and questions to the machine beside motion.

    result = system.execute_line("$110=500") # an error's number, or the commands to carry out; the first carries text

Letters are capitals and blanks are gone already.
"""

from micropython import const

from passo import commands, errors
from passo.commands import Command
from passo.protocols.grbl import report as grbl_report
from passo.protocols.gcode.words import X
from passo.protocols.grbl.lines import RX_BYTES
from passo.records import DOTS_MASK, SETTING_INCHES

_A_FEW = const(6)
_MOST_RUNS = const(100)
_CLUSTER = const(16)  # dots of a row that fit into a line whatever its numbers
_PACKED = const(100)  # the same of a packed row
_START_LINES = ("N0", "N1")
INFO = "I"


def text_answer(text):
    """Return [a command with the only purpose that `text` is the answer in its turn]."""
    command = Command(commands.HELLO)
    command.text = text
    return [command]


def text_answers(lines):
    """Return answers of a few lines each: all in one piece would ask for more memory than a board may have so."""
    parts = []
    for first in range(0, len(lines), _A_FEW):
        parts += text_answer("".join(lines[first : first + _A_FEW]))
    return parts


class System:
    def __init__(self, gcode, settings, machine, batch):
        self._gcode = gcode
        self._settings = settings
        self._machine = machine
        self._number = batch.link
        self._rows = batch.dots[DOTS_MASK]
        self.blocks = machine.blocks()
        self.probed = [0] * gcode.axes
        self.touched = False
        self._own = ()  # lines of options, see learn_lines()
        self.marks = ""  # letters of options in what `$I` says
        self._asked = ("$#", "$I", "$N")  # lines that any link may say

    def learn_lines(self, start, understand, asked=False):
        """Take an option's lines that begin with `start`: understand(machine, the rest) returns as execute_line(). `asked`: any link may say the line
        that is `start` and no more."""
        self._own += ((start, understand),)
        if asked:
            self._asked += (start,)

    def in_inches(self):
        """Return True if reports are in inches: never, if an axis counts degrees."""
        return self._settings.value(SETTING_INCHES) and not self._gcode.turns

    def execute_line(self, line):
        """Return the commands of a `$` line, or the number of an error."""
        state = self._machine.state
        if line == "$":
            return text_answer(grbl_report.HELP + "\r\n")
        if line == "$$":
            return self._all_settings() if state not in ("run", "hold") else errors.BUSY
        if line == "$G":
            return text_answer(grbl_report.modes_line(self._gcode, self.in_inches()))
        if line == "$LOG":
            return text_answers(grbl_report.log_lines(self._machine.log))
        if line == "$MASKS":
            # The board file's values of the settings that are masks, by which old ones are converted.
            return text_answer("[MASKS:%s]\r\n" % ",".join(["%d=%d" % item for item in self._settings.masks()]))
        if line[:5] == "$LINK":
            return self._do_link(line[5:])
        if line not in self._asked and self._machine.commander != self._number:
            return errors.COMMANDED_ELSEWHERE
        if line == "$C":
            return [Command(commands.CHECK, value=0 if state == "check" else 1)]
        if line == "$X":
            return [Command(commands.UNLOCK)]
        if line in ("$MOTORS=0", "$MOTORS=1"):
            return [Command(commands.CONNECT, value=int(line[8]))]
        for start, understand in self._own:
            if line.startswith(start):
                return understand(self._machine, line[len(start) :])
        if line[1:2] == "J":
            return self._do_jog(line, state)
        if state not in ("idle", "alarm"):
            return errors.BUSY
        if line == "$#":
            return text_answers(grbl_report.parameter_lines(self._gcode, self.probed, self.touched, self.in_inches(), self._machine.homed))
        if line[:2] == "$H":
            return self._do_home(line[2:])
        if line == "$SLP":
            return [Command(commands.SLEEP)]
        if line == "$I":
            return text_answer(self._info_text())
        if line[:3] == "$I=":
            return self._keep_text(INFO, line[3:])
        if line[:5] == "$RST=":
            return self._restore_settings(line[5:])
        if line[:2] == "$N":
            return self._start_lines(line, state)
        return self._change_setting(line)

    def _do_jog(self, line, state):
        """Return the commands of `$J=…`, or the number of an error."""
        if state not in ("idle", "jog"):
            return errors.BUSY
        if line[2:3] != "=":
            return errors.STATEMENT
        error = self._gcode.interpret_line(line[3:].encode(), True)
        return error or self._gcode.commands

    def _do_link(self, text):
        """Return the commands of `$LINK` or `$LINK=…`, or the number of an error."""
        machine = self._machine
        if not text:
            return text_answer("[LINK:%d,%s]\r\n" % (machine.commander + 1, machine.links[machine.commander]))
        if text[0] != "=" or text[1:] not in ("0", "1", "2", "3", "4"):
            return errors.STATEMENT
        return [Command(commands.HAND_OVER, value=int(text[1:]))]

    def _do_home(self, what):
        """Return the command of $H, $HX … (one axis) or $HR=10 (all, and ten times more to see how well it repeats), or the number of an error."""
        if not self._settings.value(22):
            return errors.HOMING_OFF
        command = Command(commands.HOME)
        axes = "XYZA" if self._gcode.axes > 3 else "XYZ"
        if len(what) == 1 and what in axes:
            command.value = 1 << axes.find(what)
        elif what[:2] == "R=" and what[2:].isdigit() and 0 < int(what[2:]) <= _MOST_RUNS:
            command.power = int(what[2:])
        elif what:
            return errors.STATEMENT
        return [command]

    def _all_settings(self):
        """Return the answer to `$$`."""
        return text_answers(["$%d=%s\r\n" % (number, self.setting_text(number)) for number in self._settings.numbers])

    def setting_text(self, number):
        """Return a setting's value as text."""
        return grbl_report.decimal_text(self._settings.value(number), self._settings.places(number))

    def _info_text(self):
        """Return the answer to `$I`."""
        text = self._settings.get(INFO) or ""
        version = "[VER:1.1h.20190830:%s]\r\n" % text  # of the grbl whose interface this is
        about = self._machine.about
        rows = "[CLUSTER:%d]\r\n[PACKED:%d]\r\n" % (_CLUSTER, _PACKED) if self._rows else ""
        if self._gcode.axes > 3:
            rows += "[AXS:4:XYZA]\r\n"
        turns = self._gcode.turns
        if turns:
            rows += "[ROTARY:A%s%s]\r\n" % (",SHORT" if turns & 2 else "", ",ENDLESS" if turns & 4 else "")
        return version + "[OPT:VNMZ%s,%d,%d]\r\n" % (self.marks, self.blocks, RX_BYTES) + rows + (grbl_report.message_line(about) if about else "")

    def _keep_text(self, key, text):
        """Keep a text in the settings. Returns the answer, or the number of an error."""
        before = self._settings.snapshot()
        try:
            self._settings.put(key, text)
        except ValueError:
            return errors.START_LINE_TOO_LONG
        return self._settings.save(before) or text_answer("")

    def _restore_settings(self, what):
        """Restore settings ($), offsets (#) or both (*). Returns the answer, or the number of an error."""
        if what not in ("$", "#", "*"):
            return errors.STATEMENT
        error = self._machine.restore_settings(what != "#", "$#*".find(what))
        if what != "$":
            self._gcode.offsets.load()
        return error or text_answer(grbl_report.message_line(grbl_report.RESTORING)) + [Command(commands.RESET)]

    def _start_lines(self, line, state):
        """Return the answer to `$N` or `$N0=…`, or the number of an error. A line is carried out before it is kept."""
        if line == "$N":
            kept = ["$%s=%s\r\n" % (key, self._settings.get(key) or "") for key in _START_LINES]
            return text_answer("".join(kept))
        key, equals, text = line[1:].partition("=")
        if key not in _START_LINES or not equals:
            return errors.STATEMENT
        if state != "idle":
            return errors.BUSY
        error = self._gcode.interpret_line(text.encode())
        if error:
            return error
        if not self._settings.keeps(text):
            return errors.START_LINE_TOO_LONG
        # Each is carried out once the one before has been accepted: a line that the machine refuses, or that ends in an alarm, is not kept.
        return self._gcode.commands + text_answer("") + [Command(commands.MORE, value=self._store_line(key, text))]

    def _store_line(self, key, text):
        """Yield the commands that keep a start-up line once it has been carried out, then None."""
        kept = errors.LOCKED if self._machine.alarm else self._keep_text(key, text)
        if isinstance(kept, int):
            yield Command(commands.BAD, error=kept)
        yield None

    def start_lines(self):
        """Return the lines for execution after a reset and after homing."""
        return [line for line in [self._settings.get(key) for key in _START_LINES] if line]

    def _change_setting(self, line):
        """Change a setting, `$100=…`. Returns the answer, or the number of an error."""
        key, equals, text = line[1:].partition("=")
        if not equals or not key or [letter for letter in key if letter not in "0123456789"]:
            return errors.STATEMENT
        places = self._settings.places(int(key))
        if places is None:
            return errors.STATEMENT
        words = self._gcode.words
        error = words.scan_line(b"X" + text.encode())
        if error or words.count or words.have != 1 << X:
            return errors.NUMBER
        return self._machine.change_setting(int(key), words.word_value(X, places)) or text_answer("")
