"""One direction of a framed link: numbers bytes, cuts them into frames, and sends them again until they are acknowledged.

    sender = Sender(baud)
    sender.put_message(b"G1X1\\n")              # a message: what one frame should hold whole
    while True:
        data = sender.next_frame(now_ms)        # then a frame of it goes out, from byte sender.number on
        if data is None: break
    sender.take_ack(ack, credit, now_ms)
    sender.send_again()                         # the other end asks; or sender.check_late(now_ms)

    messages   . . [m m m m m m m m m] . .      first: number of the first byte that is not acknowledged
                    ^first  ^at                 at: messages from there on that are under way

At most four frames are under way. After an error frames are half as long; after 16 good ones twice as long.
"""

from micropython import const

from passo.protocols.frames.codec import CREDIT_BYTES, LEAST, MOST, MOST_CREDIT, NUMBERS
from passo.records import COUNT_MASK

_FRAMES = const(4)  # under way
_GOOD = const(16)  # acknowledgements before frames are made longer
_LATE_MS = const(40)  # an answer takes, beside the time of the bytes
_LONGEST_MS = const(640)
_BITS_MS = const(10_000)  # ten bits a byte


class Sender:
    def __init__(self, baud, piece=MOST, eager=False):
        """`piece`: the size, in bytes, of the pieces into which longer messages are cut; `eager`: frames do not wait until they are full."""
        self._eager = eager
        self._baud = baud
        self._piece = piece
        self.clear_messages(0)

    def clear_messages(self, number):
        """Forget everything; the next byte has this number."""
        self.first = self.number = number
        self.messages = []
        self.kept = 0  # bytes of them
        self.flying = 0  # bytes under way
        self.size = MOST
        self._at = 0
        self._limit = MOST_CREDIT * CREDIT_BYTES
        self._good = 0
        self._since_ms = 0
        self._waits = 1  # × the time an answer may take
        self._timed = -1  # bytes still to be acknowledged until a frame is whose way is timed; -1: none is
        self._timed_ms = 0  # since when
        self._took_ms = 0  # on average

    def put_message(self, data):
        """Append a message, cut into pieces."""
        piece = self._piece
        for at in range(0, len(data), piece):
            self.messages.append(bytes(data[at : at + piece]))
        self.kept += len(data)

    def end(self):
        """Return the number behind the last byte put."""
        return (self.first + self.kept) % NUMBERS

    def next_frame(self, now_ms):
        """Return the bytes of the next frame to send, from `number` on; None if none may go now. A part of a frame waits while more than one frame is
        under way; a part below half of one, while any is."""
        messages = self.messages
        at = self._at
        if at == len(messages):
            return None
        room = min(self._limit, _FRAMES * self.size) - self.flying
        count = len(messages[at])
        if count > room and (self.flying or count > self._limit):
            return None
        end = at + 1
        while end < len(messages) and count + len(messages[end]) <= min(self.size, room):
            count += len(messages[end])
            end += 1
        if end == len(messages) and self.flying and not self._eager and (2 * count < self.size or self.flying > self.size):
            return None
        if not self.flying:
            self._since_ms = now_ms
        self.number = (self.first + self.flying) % NUMBERS
        self.flying += count
        self._at = end
        if self._timed < 0:
            self._timed = self.flying
            self._timed_ms = now_ms
        return b"".join(messages[at:end])

    def take_ack(self, ack, credit, now_ms):
        """Take an acknowledgement: the other end has every byte before `ack`, and room for `credit` credits from there on."""
        count = (ack - self.first) % NUMBERS
        if count > self.kept:
            return  # an old one
        self._limit = credit * CREDIT_BYTES
        if not count:
            return
        self._since_ms = now_ms
        self._waits = 1
        if self._timed > 0:
            self._timed -= count
            if self._timed <= 0:
                self._timed = -1
                self._took_ms = (3 * self._took_ms + ((now_ms - self._timed_ms) & COUNT_MASK)) >> 2
        messages = self.messages
        done = left = 0
        while done < len(messages) and left + len(messages[done]) <= count:
            left += len(messages[done])
            done += 1
        if left < count:  # in the middle of one
            messages[done] = messages[done][count - left :]
        self.messages = messages[done:]
        self._at = max(0, self._at - done)
        self.kept -= count
        self.flying = max(0, self.flying - count)
        self.first = ack
        self._good += 1
        if self._good >= _GOOD:
            self._good = 0
            self.size = min(MOST, 2 * self.size)

    def send_again(self):
        """Send all that is under way again, in shorter frames."""
        if self.flying:
            self.flying = self._at = 0
            self._timed = -1
            self._good = 0
            self.size = max(LEAST, self.size >> 1)

    def check_late(self, now_ms):
        """Return True, and send everything again, if the acknowledgement should have come by now."""
        if not self.flying:
            return False
        limit = (_LATE_MS + max(self.flying * _BITS_MS // self._baud, 2 * self._took_ms)) * self._waits
        if (now_ms - self._since_ms) & COUNT_MASK < min(limit, _LONGEST_MS):
            return False
        self._waits *= 2
        self.send_again()
        return True
