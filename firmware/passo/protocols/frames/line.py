"""A serial line that speaks frames once a host has asked for it, and is as it was until then.

    link.serial = FramedLine(link, link.serial, baud, clock, note)

To the app it is a serial line like the one below it; to the link's language nothing changes: it reads and writes the
bytes inside the frames. docs/reference/languages/frames.md has their form, and the rules of each end.
"""

import micropython
from micropython import const

from passo.protocols import HELLO_WIRE
from passo.protocols.frames.codec import (
    ACK, AGAIN, CHECK, CLOSED, CREDIT_BYTES, CUT, DATA, HEAD, FRAME_HELLO, LEAVE, LONGEST, MOST, MOST_CREDIT, NEW, NUMBERS,
    REPORT, TAKEN, URGENT, VERSION, WELCOME, delimit_frames, frame, parse_header, is_sound,
)  # fmt: skip
from passo.protocols.frames.errors import FRAME_LATE
from passo.protocols.frames.sender import Sender
from passo.protocols.frames.strays import Strays
from passo.records import COUNT_MASK

_PLAIN = const(0)
_OPEN = const(1)
_CLOSED = const(2)  # framed, but answers were lost: the host has to begin anew
_BUFFER = const(512)
_HOLD_MS = const(4)  # a possible beginning of HELLO is kept for this time: less than idle_gap_ms by default, so that no RESEND overtakes it
_AGAIN_MS = const(30)  # between two requests for the same bytes
_ANSWERS = const(48)  # bytes of answers that go out at once
_ANSWER_MS = const(30)  # that fewer of them may wait
_ONE = const(4)  # bytes of an answer: more are those of several lines, and there will be others
_KEPT = const(4000)  # bytes of answers that nobody takes
_PIECE = const(48)  # of a long answer
_PACKET = const(64)  # bytes of a read behind which more may wait
_CONFIRM_MS = const(1000)  # a host says something in frames after WELCOME, or the link is plain again
_MANY = const(32)  # commands that wait: more are not asked for
_FEW = const(4)  # credits of a language that does not say how much it takes


@micropython.viper
def count_zeros(data: ptr8, count: int) -> int:
    """Return how many of the first `count` bytes are 0."""
    found = 0
    while count:
        count -= 1
        if data[count] == 0:
            found += 1
    return found


class FramedLine:
    def __init__(self, link, serial, baud, clock, note):
        """`link`: has protocol and waiting; `baud`: of a UART, or any large number; `clock()`: milliseconds; `note(number)`: to the
        log."""
        self._link = link
        self._serial = serial
        self._clock = clock
        self._note = note
        self._space = getattr(link.protocol, "space", None)  # tells how many bytes the language can keep
        self._unfinished = getattr(link.protocol, "pending", None)
        self._drop_begun = getattr(link.protocol, "drop_begun", None)  # drops a message that has come in part
        self._sender = Sender(baud, _PIECE, True)
        self._state = _PLAIN
        self._strays = None  # plain once more: takes out frames that come late
        self._held = b""  # plain: a possible beginning of HELLO
        self._held_ms = 0
        self._buffer = self._view = b""  # made by the first HELLO
        self._full = False  # the last read brought a packet or more
        self._left = b""  # bytes read that found no room in the buffer
        self._heard = False  # something sound has come, see was_heard()
        self._confirmed = True  # the host has understood WELCOME
        self._begun_ms = 0
        self._clear_session()

    def _clear_session(self):
        """Forget the session: numbers, acknowledgements, answers and reports."""
        self._at = self._end = 0  # of the buffer: the first and the end of the bytes not looked at
        self._next = 0  # number of the byte wanted next
        self._urgent = 0  # number of the urgent frame wanted next
        self._new = True
        self._owes = False  # an acknowledgement
        self._told = 0  # credits, by the last one
        self._asked = -1  # the byte that was asked for again
        self._asked_ms = 0
        self._answers = b""  # that wait to be sent
        self._answer_ms = 0  # since when
        self._todo = True  # _send_waiting() is to be called
        self._every_ms = 0
        self._reported_ms = 0
        self._question = b""
        self._sender.clear_messages(0)

    # --- the face of a serial line

    def was_heard(self):
        """Return True if anything sound has come since the last call."""
        heard = self._heard
        self._heard = False
        return heard

    def any(self):
        """Return True if bytes wait."""
        if self._left or self._at < self._end and self._buffer.find(b"\0", self._at, self._end) >= 0:
            return True
        return self._serial.any()

    def read(self):
        """Return bytes for the language, good until the next read; b"" if there are none."""
        if self._state == _PLAIN:
            data = self._serial.read()
            if not data or self._strays or self._held or count_zeros(data, len(data)):
                return self._read_plain(data)
            self._heard = True
            return data
        begin = self._at
        end = self._buffer.find(b"\0", begin, self._end) if begin < self._end else -1
        while end < 0 and self._fill_buffer():
            begin = 0
            end = self._buffer.find(b"\0", 0, self._end)
            if not self._full:
                break
        while end >= 0:
            self._at = end + 1
            if end - begin >= HEAD + CHECK:
                data = self._do_frame(begin, end)
                if data:
                    return data
                if self._state == _PLAIN:
                    return b""
            begin = self._at
            end = self._buffer.find(b"\0", begin, self._end)
        return self._send_waiting() if self._todo else b""

    def write(self, data):
        """Send an answer, in a frame with others: at once if many bytes wait, or the language has nothing more to say."""
        if self._state == _PLAIN:
            self._serial.write(data)
            return
        if not self._answers:
            self._todo = True
            self._answer_ms = self._clock()
        self._answers += data
        if len(self._answers) >= _ANSWERS or not (self._unfinished and (_ONE < len(data) < _ANSWERS or self._unfinished())):
            self._send_answers()

    def close(self):
        """Close the line below."""
        self._serial.close()

    # --- until a host asks for frames

    def _read_plain(self, data):
        """Return the bytes of `data` for the language; after LEAVE without frames that come late."""
        strays = self._strays
        if data:
            self._heard = True
            held = strays.held if strays else self._held
            text = held + bytes(data)
            at = text.find(HELLO_WIRE)
            if at >= 0:
                self._begin_session(text[at + len(HELLO_WIRE) :])
            if strays:
                data = strays.without_frames(data if at < 0 else text[len(held) : max(at, len(held))], self._clock())
            else:
                self._held = b""
                if at < 0:
                    at = text.rfind(b"\0")
                    if at >= 0 and HELLO_WIRE.startswith(text[at:]):
                        self._held = text[at:]
                        self._held_ms = self._clock()
                    else:
                        at = len(text)
                data = text[:at]
        elif strays:
            data = strays.after_silence(self._clock())
        elif self._held and (self._clock() - self._held_ms) & COUNT_MASK >= _HOLD_MS:
            data = self._held
            self._held = b""
        if strays and strays.found:
            strays.found = 0
            self._note(FRAME_LATE)
        return data

    def _begin_session(self, rest):
        """Begin a session: HELLO has come, and `rest` behind it. Allocates the buffer at the first."""
        if not self._buffer:
            self._buffer = bytearray(_BUFFER)
            self._view = memoryview(self._buffer)
        self._clear_session()
        self._state = _OPEN
        protocol = self._link.protocol
        self._strays = Strays(getattr(protocol, "binary", False), getattr(protocol, "is_amid", None))
        self._left = rest
        self._confirmed = False
        self._begun_ms = self._clock()
        self._send_welcome()

    # --- bytes to frames

    def _fill_buffer(self):
        """Put new bytes behind those in the buffer. Returns False if there are none."""
        data = self._left or self._serial.read()
        if not data:
            return False
        at = self._at
        held = self._end - at
        if held > LONGEST:
            held = 0  # noise without a delimiter
        if held and at:
            self._buffer[:held] = self._buffer[at : at + held]
        self._at = 0
        room = _BUFFER - held
        if len(data) > room:
            self._left = bytes(data[room:])
            data = data[:room]
        else:
            self._left = b""
        count = held + len(data)
        self._buffer[held:count] = data
        self._end = count
        self._full = len(data) >= _PACKET
        return True

    def _do_frame(self, begin, end):
        """Do what a frame asks for. Returns the bytes in it that are for the language, or None."""
        if not is_sound(self._buffer, begin, end):
            self._ask_again()
            return None
        self._heard = True
        kind, number, ack, credit = parse_header(self._buffer, begin)
        if kind == FRAME_HELLO:
            if self._state == _CLOSED:
                self._clear_session()
                self._state = _OPEN
            self._send_welcome()
            return None
        if self._state == _CLOSED:
            self._serial.write(delimit_frames(frame(CLOSED)))
            return None
        self._confirmed = True
        data = self._view[begin + HEAD : end - CHECK]
        self._sender.take_ack(ack, credit, self._clock())
        if kind == DATA:
            return self._take_data(number, data)
        if kind == ACK or kind == AGAIN:
            if kind == AGAIN:
                self._sender.send_again()
            self._send_answers()
            return None
        return self._take_urgent(kind, number, data)

    def _take_data(self, number, data):
        """Return the new ones of the bytes from `number` on; None if there are none, or some before them are missing."""
        known = (self._next - number) % NUMBERS
        if known > NUMBERS >> 1:
            self._ask_again()
            return None
        self._owes = self._todo = True
        if known >= len(data):
            return None
        if self._new:
            self._begin_use()
        self._next = (number + len(data)) % NUMBERS
        return data[known:] if known else data

    def _begin_use(self):
        """Drop a message that the language has in part: the session begins to be used, or ends."""
        self._new = False
        if self._drop_begun:
            self._drop_begun()

    def _take_urgent(self, kind, number, data):
        """Take an urgent frame once, and acknowledge it. Returns its bytes for the language, or None."""
        if not URGENT <= kind <= LEAVE:
            return None
        fresh = number == self._urgent
        if fresh:
            if kind != URGENT and kind != LEAVE and len(data) < 2:
                return None
            if self._new or kind == LEAVE:
                self._begin_use()
            self._urgent = (number + 1) % NUMBERS
            if kind == CUT:
                behind = data[0] << 8 | data[1]
                if (behind - self._next) % NUMBERS < NUMBERS >> 1:
                    self._next = behind
                data = data[2:]
            elif kind == REPORT:
                self._todo = True
                self._every_ms = data[0] << 8 | data[1]
                self._question = bytes(data[2:])
                self._reported_ms = self._clock()
        elif (number + 1) % NUMBERS != self._urgent:
            return None
        self._serial.write(delimit_frames(self._make_frame(TAKEN, number)))
        if kind == LEAVE:
            self._state = _PLAIN
            self._at = self._end = 0
            return None
        return data if fresh and kind != REPORT else None

    # --- frames to bytes

    def _free_credits(self):
        """Return how many credits the language can take."""
        if self._space:
            return min(MOST_CREDIT, self._space() // CREDIT_BYTES)
        waiting = len(self._link.waiting)
        return _FEW if not waiting else 1 if waiting < _MANY else 0  # STOP and STATUS do not wait for commands in the queue

    def _make_frame(self, kind, number=0, data=b""):
        """Return a frame with the newest acknowledgement and credits."""
        self._owes = False
        self._told = self._free_credits()
        return frame(kind, number, self._next, self._told, data)

    def _send_welcome(self):
        """Send WELCOME: version, whether the session is new, and the numbers expected."""
        about = bytes((VERSION, NEW if self._new else 0, MOST, self._urgent >> 8, self._urgent & 255))
        self._serial.write(delimit_frames(self._make_frame(WELCOME, self._sender.end(), about)))

    def _ask_again(self):
        """Ask for the next byte again, at most once in _AGAIN_MS."""
        now_ms = self._clock()
        if self._state == _OPEN and (self._asked != self._next or (now_ms - self._asked_ms) & COUNT_MASK >= _AGAIN_MS):
            self._asked = self._next
            self._asked_ms = now_ms
            self._serial.write(delimit_frames(self._make_frame(AGAIN)))

    def _send_answers(self):
        """Send as many of the answers as may be under way. Closes the session if too many are not acknowledged."""
        sender = self._sender
        if self._answers:
            self._todo = True
            if self._state == _OPEN and sender.kept + len(self._answers) <= _KEPT:
                sender.put_message(self._answers)
            else:
                self._state = _CLOSED
                sender.clear_messages(0)
            self._answers = b""
        now_ms = self._clock()
        data = sender.next_frame(now_ms)
        while data is not None:
            self._serial.write(delimit_frames(self._make_frame(DATA, sender.number, data)))
            data = sender.next_frame(now_ms)

    def _send_waiting(self):
        """Send what is due now that nothing has come: answers, credits, reports. Returns a report's question, or b""."""
        if self._state == _CLOSED:
            return b""
        sender = self._sender
        if not self._confirmed and (self._clock() - self._begun_ms) & COUNT_MASK >= _CONFIRM_MS:
            self._state = _PLAIN
            self._at = self._end = 0
            self._serial.write(b"".join(sender.messages) + self._answers)
            return b""
        if sender.kept or self._answers:
            now_ms = self._clock()
            if sender.check_late(now_ms) or sender.kept and not sender.flying or self._answers and (now_ms - self._answer_ms) & COUNT_MASK >= _ANSWER_MS:
                self._send_answers()
        if self._owes and not self._answers or self._told < _FEW and self._free_credits() > self._told:
            self._serial.write(delimit_frames(self._make_frame(ACK)))
        self._todo = bool(sender.kept or self._answers or self._owes or self._told < _FEW or self._every_ms or not self._confirmed)
        if self._every_ms and not sender.kept:
            now_ms = self._clock()
            if (now_ms - self._reported_ms) & COUNT_MASK >= self._every_ms:
                self._reported_ms = now_ms
                return self._question
        return b""
