"""The reference client of docs/reference/languages/frames.md: a serial port whose bytes go in frames, so that none is lost, doubled or changed.

    opened = offer_frames(serial.Serial("/dev/ttyACM0", 115200, timeout=0.05))    # a FramedPort, or the same port if the board has no frames
    opened.write(b"G1X1\\n")                # one message: a line, a packet, a command
    opened.read(100)                        # bytes of the board, as from a serial port
    opened.urgent(b"!")                     # ahead of all that is written
    opened.urgent(b"\\x18", cut=True)        # and drop written bytes that have not come
    opened.report(250, b"?")                # the board asks itself every 250 ms
    opened.close()

It works while it is called: read(), write(), in_waiting. Raises OSError if the board does not answer, or has been reset.
"""

import re
import time

from host_tools.language import _
from passo.protocols.frames import codec
from passo.protocols import HELLO_WIRE
from passo.protocols.frames.codec import ACK, AGAIN, CUT, DATA, LEAVE, NUMBERS, REPORT, TAKEN, URGENT, WELCOME
from passo.protocols.frames.sender import Sender

SLICE_S = 0.004  # a look at the wire
OFFER_S = 0.25  # after which a board without frames is one
SURE_S = 1.0  # the same on a wire that may be bad
_LEAVES = 10  # attempts to end another program's session: on a wire that loses 1 % of the bytes each third fails
_OFFER_AGAIN_MS = 80
_SILENT_MS = 250  # then nothing but HELLO is sent
_LOST_MS = 5000
_URGENT_MS = 60
_SILENCE_MS = 60  # before the next frame a delimiter cuts off what noise has left
_ACK_MS = 40  # an acknowledgement waits for bytes to go with
_USB_BAUD = 1_000_000
# Asks a language of lines for something harmless, and makes an error of a line that another program has left unfinished: an empty line would
# have it carried out.
_PROBE = b"$G\n"
_ENDED = re.compile(rb"(?:^|\n)(ok|error:\d+)\r?\n")


def offer_frames(port, wait_s=OFFER_S, text=False, patient=False):
    """Return a FramedPort on the open pyserial port `port` if the board answers HELLO within `wait_s`, else `port`. `text`: the link's
    language has lines, each answered by one, so a board without frames shows at once. `patient`: wait all the same, because on a bad wire a
    board with frames may miss the first HELLO."""
    opened = framed = FramedPort(port)
    if not framed.begin(wait_s, text and not patient):
        port.timeout = framed.timeout
        opened = port
    if text:
        opened.write(_PROBE)  # ends the line begun by HELLO, or by another program's frames before it
        heard, end_ms = b"", _clock_ms() + 1000 * wait_s
        while not _ENDED.search(heard) and _clock_ms() < end_ms:
            heard += opened.read(1)
    return opened


def _clock_ms():
    """Milliseconds of a clock that never goes back."""
    return time.monotonic_ns() // 1_000_000


class FramedPort:
    def __init__(self, port, clock=_clock_ms):
        """`clock()`: milliseconds."""
        self._port, self._clock = port, clock
        self.timeout, port.timeout = port.timeout, SLICE_S
        self._sender = Sender(port.baudrate or _USB_BAUD)
        self._wire = bytearray()  # of frames that have not ended
        self._received = bytearray()
        self._urgents = []  # (kind, bytes) not yet taken
        self._urgent = 0  # number of the first of them
        self._urgent_ms = None  # when it was sent
        self._next = 0  # number of the byte wanted next
        self._asked_ms = 0
        self._owes_ms = None  # since when an acknowledgement is owed
        self._new = self._open = self._leaving = False
        self._delimited = False  # a byte 0 has come, which no language of lines has
        self._said_ms = 0  # of HELLO; 0: not yet
        self._pleading_ms = None  # since then only HELLO is sent; set by a call, so that a program that paused loses nothing
        self._heard_ms = self._sent_ms = clock()

    def begin(self, wait_s, text=False):
        """Open a new session. False if nobody answers HELLO within `wait_s`, or, with `text`, something else answers a line. Raises OSError if
        another program's session cannot be ended."""
        asked = not text
        for again in range(_LEAVES):
            begun_ms = self._clock()
            self._open = False
            while not self._open:
                patience_s = max(wait_s, SURE_S) if self._delimited else wait_s
                if self._clock() - begun_ms >= 1000 * patience_s or text and not self._delimited and _ENDED.search(self._wire):
                    return False
                if self._offer_session() and not asked:
                    asked = True  # once: every answer has to be waited for
                    self._port.write(_PROBE)
                self._poll_wire()
            if self._new:
                return True
            self._leave_session()  # another program's session: end it, and begin anew
        raise OSError(_("the session of frames that another program has left open does not end"))

    # --- the face of a serial port

    @property
    def in_waiting(self):
        """Bytes received and not read. Raises OSError if the board does not answer."""
        self._poll_wire()
        return len(self._received)

    def read(self, size=1):
        """Up to `size` bytes of the board's messages; waits for the first at most `timeout` seconds. Raises OSError if the board does not
        answer."""
        end_ms = self._clock() + 1000 * (self.timeout or 0)
        self._poll_wire()
        while not self._received and self._clock() < end_ms:
            self._poll_wire()
        data = bytes(self._received[:size])
        del self._received[:size]
        return data

    def write(self, data):
        """Send one message; returns at once, later calls repeat it until the board has it. Raises OSError if the board does not answer."""
        self._expect_nothing()
        self._sender.put_message(data)
        self._send_due()

    def urgent(self, data, cut=False):
        """Send real-time bytes ahead of written ones. `cut`: the board drops bytes that were written before and have not come."""
        if cut:
            sender = self._sender  # less than half of the numbers are under way, or the board could not tell old from new
            behind = (sender.first + min(sender.kept, NUMBERS // 2 - 1)) % NUMBERS
            sender.clear_messages(behind)
            data = behind.to_bytes(2, "big") + data
        self._urgents.append((CUT if cut else URGENT, data))
        self._send_due()

    def report(self, every_ms, question):
        """Have the board ask itself `question` every `every_ms` ms and send the answer; 0: stop that."""
        self._urgents.append((REPORT, every_ms.to_bytes(2, "big") + question))
        self._send_due()

    def reset_input_buffer(self):
        """Forget bytes received and not read."""
        self._poll_wire()
        self._received.clear()

    def close(self):
        """Wait up to 1 s until the board has all written bytes, end the session, and close the port."""
        try:
            end_ms = self._clock() + 1000
            while (self._sender.kept or self._urgents) and self._clock() < end_ms:
                self._poll_wire()
            self._leave_session()
        except OSError:
            pass
        self._port.close()

    # --- frames

    def _send_frame(self, kind, number=0, data=b""):
        """Write one frame to the port, without its first delimiter if frames have their full size and the last one went less than 60 ms ago."""
        now_ms, self._owes_ms = self._clock(), None
        wire = codec.delimit_frames(codec.frame(kind, number, self._next, codec.MOST_CREDIT, data))
        follows = self._sender.size == codec.MOST and now_ms - self._sent_ms < _SILENCE_MS
        self._port.write(wire[1:] if follows else wire)
        self._sent_ms = now_ms

    def _offer_session(self):
        """Send HELLO, if it is time; True if it is."""
        if self._said_ms and self._clock() - self._said_ms < _OFFER_AGAIN_MS:
            return False
        self._said_ms = self._clock()
        self._port.write(HELLO_WIRE)
        return True

    def _leave_session(self):
        """End the session: send LEAVE once, then nothing until TAKEN, for at most 50 ms. A board that has taken LEAVE reads the bytes of a
        frame as its language."""
        self._expect_nothing()
        begun_ms = self._clock()
        self._leaving = self._open and begun_ms - self._heard_ms <= _SILENT_MS
        if self._leaving:
            self._send_frame(LEAVE, self._urgent)
        self._open, self._urgents, self._urgent_ms, self._owes_ms = False, [], None, None
        while self._leaving and self._clock() - begun_ms < _URGENT_MS - 10:
            self._poll_wire()
        self._leaving, self._said_ms = False, 0

    def _expect_nothing(self):
        """If no acknowledgement, no credit and no TAKEN is awaited, the board may be silent up to now."""
        if not self._sender.kept and self._urgent_ms is None:
            self._heard_ms = self._clock()

    def _send_due(self):
        """Send what may be sent now."""
        if not self._open:
            return
        now_ms, sender = self._clock(), self._sender
        self._expect_nothing()
        if now_ms - self._heard_ms > _SILENT_MS:
            if self._pleading_ms is None:
                self._pleading_ms = now_ms
            if now_ms - self._pleading_ms > _LOST_MS:
                raise OSError(_("the board does not answer any more"))
            self._offer_session()
            return
        self._pleading_ms = None
        if self._urgents and (self._urgent_ms is None or now_ms - self._urgent_ms >= _URGENT_MS):
            self._urgent_ms = now_ms
            self._send_frame(self._urgents[0][0], self._urgent, self._urgents[0][1])
        sender.check_late(now_ms)
        if not any(kind == CUT for kind, _ in self._urgents):
            while (data := sender.next_frame(now_ms)) is not None:
                self._send_frame(DATA, sender.number, data)

    def _poll_wire(self):
        """Take bytes of the port, and send what is due."""
        data = self._port.read(max(1, self._port.in_waiting))
        *whole, self._wire = (self._wire + data).split(b"\0")
        self._delimited = self._delimited or bool(whole)
        for chunk in whole:
            if len(chunk) >= codec.HEAD + codec.CHECK:
                self._take_frame(bytearray(chunk))
        self._send_due()
        if self._pleading_ms is None and self._owes_ms is not None and self._clock() - self._owes_ms >= _ACK_MS:
            self._send_frame(ACK)

    def _take_frame(self, chunk):
        """Take a frame without its delimiters (docs/reference/languages/frames.md). Raises OSError if the board lost answers."""
        if not codec.is_sound(chunk, 0, len(chunk)):
            return self._ask_again()
        self._heard_ms = self._clock()
        kind, number, ack, credit = codec.parse_header(chunk, 0)
        data = chunk[codec.HEAD : -codec.CHECK]
        if self._leaving:
            self._leaving = kind != TAKEN or number != self._urgent
        elif kind == WELCOME:
            self._take_welcome(data, number, ack, credit)
        elif self._open and kind == codec.CLOSED:
            raise OSError(_("answers of the board were lost"))
        elif self._open:
            self._sender.take_ack(ack, credit, self._heard_ms)
            if kind == DATA:
                self._take_data(number, data)
            elif kind == AGAIN:
                self._sender.send_again()
            elif kind == TAKEN and self._urgents and number == self._urgent:
                self._urgents.pop(0)
                self._urgent, self._urgent_ms = (self._urgent + 1) % NUMBERS, None

    def _take_welcome(self, about, number, ack, credit):
        """Take WELCOME: open the session, or notice that the board has begun a new one. Raises OSError then."""
        new = bool(about[1] & codec.NEW)
        if not self._open:
            self._open, self._new = True, new
            self._next, self._urgent = number, about[3] << 8 | about[4]
            self._sender.clear_messages(ack)
            self._send_frame(ACK)
        elif new and (self._sender.first or self._urgent):
            raise OSError(_("the board has been reset"))
        self._sender.take_ack(ack, credit, self._heard_ms)

    def _take_data(self, number, data):
        """Take the bytes of a DATA frame that begins at byte `number`; ask again if earlier ones are missing."""
        known = (self._next - number) % NUMBERS
        if known > NUMBERS // 2:
            return self._ask_again()
        if self._owes_ms is None:
            self._owes_ms = self._clock()
        if known < len(data):
            self._received += data[known:]
            self._next = (number + len(data)) % NUMBERS

    def _ask_again(self):
        if self._open and self._pleading_ms is None and self._clock() - self._asked_ms >= 30:
            self._asked_ms = self._clock()
            self._send_frame(AGAIN)
