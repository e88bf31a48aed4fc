"""Admits senders at a port of this PC, which any program here can reach, only after the operator agrees.

    consent = Consent()                         # of one start of a program
    line = GuestLine(TcpLine(5000), consent)    # as a line of serial_line.py or websocket_line.py
    consent.poll()                              # a few times a second: reads the operator's answer
    consent.give_consent()                              # the page's button

Until then a sender may only look: questions, `?`, hold, door, jog cancel and reset pass. Any other line is error 178 and asks the operator: once a
start, in the program's terminal (y or n), or on the page. Without either, the token that was printed at the start admits a connection whose first
line it is: `$TOKEN=ABCD-EFGH-JKLM-NPQR`.
"""

import os
import select
import sys

from host_tools.language import _
from passo import errors
from host_tools.page.guest_sender import ALWAYS, QUESTIONS
from host_tools.clients.page_key import in_groups, make_key, read_key
from passo.web.session import same_text

_LONGEST = 256  # bytes of a line that is kept
_MOST = 256  # lines
_TOKEN = b"$TOKEN="
_REFUSED = b"error:%d\r\n" % errors.NOT_ADMITTED
_STATUS = 0x3F
_YES = ("y", "yes", "s", "sim")


class Consent:
    def __init__(self):
        self.given = False
        self.token = make_key(os.urandom)
        self.asked = False  # a sender wants to move the machine
        self._answered = False
        self.terminal = _has_operator()

    def ask_operator(self, name):
        """Ask the operator in the terminal, once a start, whether the program at `name` may move the machine."""
        if self.asked:
            return
        self.asked = True
        if self.terminal:
            print(_("a program at {} wants to move the machine: let it until this ends? y/n", name), end=" ", flush=True)

    def give_consent(self):
        """Let senders move the machine until this program ends."""
        self.given = self._answered = True

    def admits_token(self, text):
        """True if a sender's first line has the token."""
        try:
            return same_text(read_key(text), self.token)
        except ValueError:
            return False

    def poll(self):
        """Take the operator's answer, if one has been typed. Never waits for it."""
        if not self.asked or self._answered or not self.terminal or not select.select([sys.stdin], [], [], 0)[0]:
            return
        if not _has_operator():
            return  # moved to the background since: reading would stop this program
        self._answered = True
        self.given = sys.stdin.readline().strip().lower() in _YES
        print(_("it may") if self.given else _("it may not: start this program again to be asked again"), flush=True)


class GuestLine:
    """A line whose client must be admitted. Refusals come behind the board's answers to the lines that passed."""

    def __init__(self, line, consent):
        self._line = line
        self.consent = consent
        self._client = None  # number of the client that is there
        self._admitted = False  # by the token
        self._first = True  # its first line has not come yet
        self._typed = b""
        self._held = []  # lines that came, with their ends; one after the other, each behind the answers of those before
        self._unanswered = 0
        self._said = b""  # the begin of a line from the board
        self.name = line.name

    def read(self):
        """Return the bytes that may go to the board: all from an admitted client, else status requests, resets and the lines that anyone may send."""
        data = self._line.read()
        if self._line.clients != self._client:
            self._client = self._line.clients
            self._admitted, self._first, self._typed, self._held, self._unanswered = False, True, b"", [], 0
        if self._may_pass():
            held, self._held = b"".join(self._held), []
            typed, self._typed = self._typed, b""
            return held + typed + data
        out = bytearray()
        for byte in data:
            if byte == _STATUS or byte in ALWAYS:
                out.append(byte)
                if byte == 0x18:
                    self._typed, self._held, self._unanswered = b"", [], 0
            elif byte < 0x80 and byte != 0x7E:
                self._typed = (self._typed + bytes((byte,)))[:_LONGEST]
                if byte == 0x0A:
                    self._held += [self._typed.strip() + b"\n"][: _MOST - len(self._held)]
                    self._typed = b""
        return bytes(out) + self._pass_lines()

    def _may_pass(self):
        return self.consent.given or self._admitted

    def _pass_lines(self):
        """Return the bytes of the held lines that may pass to the board."""
        out = b""
        while self._held:
            word = self._held[0].strip().upper()
            if self._may_pass():
                out += b"".join(self._held)
                self._held = []
            elif not word or word in QUESTIONS:
                out += self._held.pop(0)
                self._unanswered += 1
            elif self._unanswered:
                break
            elif self._first and word.startswith(_TOKEN):
                self._held.pop(0)
                self._admitted = self.consent.admits_token(word[len(_TOKEN) :].decode("ascii", "replace"))
                self._line.write(b"ok\r\n" if self._admitted else _REFUSED)
            else:
                self._held.pop(0)
                self._line.write(_REFUSED)
                self.consent.ask_operator(self.name)
            self._first = False
        return out

    def write(self, data):
        """Send the board's bytes to the client, and count its answers to the lines that passed."""
        self._line.write(data)
        if self._may_pass():
            return
        lines = (self._said + bytes(data)).split(b"\n")
        self._said = lines.pop()[-_LONGEST:]
        answers = sum(line.startswith((b"ok", b"error:")) for line in lines)
        self._unanswered = max(0, self._unanswered - answers)

    def select_list(self):
        return self._line.select_list()

    def close(self):
        self._line.close()


def _has_operator():
    """True if an operator may type: stdin is a terminal, and this program is the one in front."""
    try:
        return sys.stdin.isatty() and os.tcgetpgrp(sys.stdin.fileno()) == os.getpgrp()
    except (OSError, ValueError, AttributeError):
        return False


def print_port(line):
    """Print the port for senders, and the token for their first line if nobody can be asked."""
    print(f"port: {line.name}", flush=True)
    if line.consent and not line.consent.terminal:
        print(_("token: {}   (the first line of a sender: $TOKEN=…)", in_groups(line.consent.token)), flush=True)
