"""The plotter's packets as the page's machine speaks them: commands out, answers and reports in.

    wire = PlotterWire(write, board, machine)       # machine.take_answer(event), machine.report(dict)

One packet is under way at a time. The language has no word for "no": STATUS, which is asked all the time, tells the refusals. If a later STATUS is
answered, but not the packet before it, the packet was lost and is sent again; a point twice is a line of no length.
"""

from micropython import const

from host_tools.clients.answers import answer_of, is_complete, setting_line
from passo import commands, errors
from passo.commands import ACCEPTED, REFUSED, Event
from passo.protocols.page.plotter import PlotterPage, jogs_of
from passo.protocols.plotter.host import ANSWERS, COMMANDS, STATUS_LENGTH, packet, status_from, words_packets

_LOST = const(3)  # STATUS answered behind a packet that was not
_ATTEMPTS = const(8)
_LINE_ATTEMPTS = const(2)  # a board may know no lines
_TORN_MS = const(400)  # of a STATUS: the rest does not come any more
_NAMES = {commands.DRAW: "END", commands.SPEED: "SPEED", commands.HOME: "ORIGIN", commands.STOP: "STOP", commands.HAND_OVER: "LINK"}
_ANSWER_TO = {commands.POINT: "NEXT", commands.JOG: "NEXT", commands.DRAW: "DONE", commands.SPEED: "SPEED_OK", commands.HOME: "ORIGIN_OK",
              commands.STOP: "DONE", commands.HAND_OVER: "LINK_OK"}  # fmt: skip
_BEGIN = b"[$oe"  # the first bytes of an answer of lines
_TAKES_TIME = (commands.DRAW, commands.HOME, commands.STOP)  # answered when they are done


class PlotterWire:
    def __init__(self, write, board, machine):
        self.write = write
        self._machine = machine
        self._jogs = jogs_of(board)
        self._buffer = b""
        self._heard_ms = 0
        self._command = None  # under way
        self._asked = 0  # STATUS answered since it was sent
        self._idle = 0  # of these the newest in a row that said idle
        self._attempts = 0
        self.retries = 0  # packets that were sent again
        self._packets = []  # those of a line about settings that are left
        self._text = None  # of its answer so far, once all have been sent
        self._told = 0  # the error of such an answer: the next STATUS has it, too

    # --- commands

    def can_take(self, command):
        """True if `command` can be sent now: no packet is under way, or it is a STOP."""
        return self._command is None or command.kind == commands.STOP

    def send_command(self, command):
        """Send a command. Its event follows at the machine; a STOP ends the command under way."""
        if self._command is not None:
            self._end_command(errors.NO_ANSWER if self._command.kind == commands.SETTING else 0)  # a STOP overtakes it
        self._command = command
        self._attempts = 0
        self._send_packets()

    def _send_packets(self):
        """Send the packet of the command under way, again if it got lost; for a setting the first of its packets."""
        command = self._command
        self._asked = self._idle = 0
        if command.kind == commands.SETTING:
            self._packets = words_packets(setting_line(command))
            self._text = None
            self._send_words()
            return
        if command.kind == commands.POINT:
            data = packet(COMMANDS["LINE" if command.tool else "MOVE"], command.target[0], command.target[1])
        elif command.kind == commands.JOG:
            data = packet(COMMANDS[self._jogs[command.target]])
        else:
            data = packet(COMMANDS[_NAMES[command.kind]], command.value if command.kind == commands.SPEED else 0)
        self.write(data)

    def _send_words(self):
        self.write(self._packets.pop(0))
        if not self._packets:
            self._text = ""

    def _end_command(self, error, told=None):
        """End the packet under way with an event: REFUSED if `error`, else ACCEPTED with the lines `told`."""
        command, self._command = self._command, None
        self._text = None
        self._machine.take_answer(Event(REFUSED if error else ACCEPTED, command, error, told))

    def ask_report(self):
        """Ask for STATUS."""
        self.write(packet(COMMANDS["STATUS"]))

    def drop(self):
        """Give up the command under way: NO_ANSWER."""
        self._buffer = b""
        if self._command is not None:
            self._end_command(errors.NO_ANSWER)

    note_silence = drop

    # --- answers

    def feed(self, data, now_ms):
        """Take bytes of the board: STATUS has twelve, every other answer one. Drops a STATUS that is torn for longer than _TORN_MS."""
        if self._buffer and (now_ms - self._heard_ms) % 0x20000000 > _TORN_MS:
            self._buffer = b""
        self._heard_ms = now_ms
        self._buffer += bytes(data)
        while self._buffer:
            first = self._buffer[0]
            if first != COMMANDS["STATUS"]:
                self._buffer = self._buffer[1:]
                if self._text is None or not self._text and first not in _BEGIN:
                    self._take_answer(ANSWERS.get(first))
                else:
                    self._hear_text(chr(first))
                continue
            if len(self._buffer) < STATUS_LENGTH:
                return
            try:
                status = status_from(self._buffer[:STATUS_LENGTH])
            except (ValueError, IndexError):
                self._buffer = self._buffer[1:]
                continue
            self._buffer = self._buffer[STATUS_LENGTH:]
            self._take_status(status)

    def _hear_text(self, letter):
        """Add a letter of a text answer, and end the command under way once the text is complete."""
        self._text += letter
        if is_complete(self._text):
            self._told, told = answer_of(self._text)
            self._end_command(self._told, told)

    def _take_answer(self, answer):
        """Take a one-byte answer, by name: it ends the command under way, or asks for the next packet of a setting."""
        if self._packets and self._command.kind == commands.SETTING and answer == "REQUEST_OK":
            self._asked = 0
            self._send_words()
        elif self._command is not None and self._command.kind == commands.SETTING:
            return
        elif self._command is not None and answer == _ANSWER_TO[self._command.kind]:
            self._end_command(0)

    def _take_status(self, status):
        """Take the fields of a STATUS: judge the packet under way, and report to the machine."""
        status["position"] = [status["x"], status["y"]]
        if status["error"] == self._told:
            status["error"] = 0
        self._told = 0
        if self._command is not None:
            self._judge_packet(status["state"], status["error"], status["free"])
        self._machine.report(status)

    def _judge_packet(self, name, error, free):
        """Decide from the fields of a STATUS whether the packet under way was refused, is held back, or got lost and must be sent again."""
        kind = self._command.kind
        refused = error if error == errors.STOPPED or error not in PlotterPage.untold else 0
        if refused or name == "alarm" and kind not in (commands.HOME, commands.STOP):
            self._end_command(refused or errors.LOCKED)
            return
        self._asked += 1
        self._idle = self._idle + 1 if name in ("idle", "alarm") else 0
        waits = kind == commands.POINT and free == 0 or kind in _TAKES_TIME and not self._idle or kind == commands.JOG and name == "jog"
        if waits or (self._idle if kind in _TAKES_TIME else self._asked) < _LOST:
            return
        self._attempts += 1
        if kind == commands.JOG or self._attempts > (_LINE_ATTEMPTS if kind == commands.SETTING else _ATTEMPTS):
            self._end_command(errors.NO_ANSWER)
        else:
            self.retries += 1
            self._send_packets()
