"""The plotter's language of 2014: packets of six bytes, `command hiX loX hiY loY checksum`, answered by one byte.

    plotter = Plotter()
    for command in plotter.feed(serial.read(), now_ms): …
    serial.write(plotter.reply(event))

No single byte lost, doubled or flipped can draw a wrong line, as long as the host waits for its answers:

- A flipped byte breaks the checksum. All bytes are then dropped until the line is quiet for `gap_ms`; RESEND follows. If the six bytes
  of STOP are among them, the machine stops instead.
- A lost byte leaves a packet unfinished. After RESYNC_MS it is dropped and RESEND follows.
- A doubled byte makes seven. Their first six could be valid by chance (1 in 256), so six bytes in which a byte
  repeats its neighbour are held for `gap_ms`. If a seventh arrives that would make them another valid packet with one
  of the twins removed, nobody knows which was meant: they are dropped, and RESEND follows. A checksum that comes twice
  leaves one byte behind a packet that has its answer: after RESYNC_MS alone it is dropped, and nothing follows.

A byte lost and another doubled may leave a good sum behind an unknown command: that is answered as a bad sum is.

STOP, STATUS, LINK (the link of number X commands from now on; 0: this one) and WORDS (see words.py) are extensions. The board
never speaks unasked.
"""

import struct

import micropython
from micropython import const

from passo import errors
from passo.commands import (
    ACCEPTED, BAD, DRAW, FINISHED, HAND_OVER, HELLO, HOME, JOG, POINT, SPEED, STATUS, STOP, Command,
)
from passo.records import COUNT_MASK

RESYNC_MS = const(2000)
PACKET = const(6)
_HELD = const(2)  # as sift_points() returns
_OTHER = const(3)

# The first byte of a packet.
REQUEST = const(0x72)
LINE = const(0x6C)
MOVE = const(0x6D)
END = const(0x65)
ORIGIN = const(0x6F)
SET_SPEED = const(0x73)
UP = const(0x38)
LEFT = const(0x34)
DOWN = const(0x32)
RIGHT = const(0x36)
HALT = const(0x78)
ASK = const(0x3F)
LINK = const(0x74)
WORDS = const(0x24)

_SIMPLE = {REQUEST: HELLO, END: DRAW, ORIGIN: HOME, HALT: STOP, ASK: STATUS}
_ON_ACCEPTED = {HELLO: b"k", POINT: b"n", JOG: b"n", SPEED: b"s", HAND_OVER: b"t"}
_ON_FINISHED = {DRAW: b"d", HOME: b"o", STOP: b"d"}
_RESEND = b"r"


@micropython.viper
def judge_packet(data: ptr8, first: int, before: int, spare: int) -> int:
    """Judge the six bytes from data[first] on. Returns 0 for a packet; 1 for none, or more than one; 2 for a packet in which a byte repeats its
    neighbour."""
    doubt = 0
    total = 0
    index = first
    while index < first + 6:
        byte = int(data[index])
        if byte == before:
            doubt = 2
            if byte == spare:
                return 1
        before = byte
        total += byte
        index += 1
    return 1 if (total - 2 * int(data[first + 5])) & 255 else doubt


@micropython.viper
def sift_points(data: ptr8, count: int, before: int, quiet: int, out: ptr8, at: int, room: int, most_x: int, most_y: int) -> int:
    """The points at the start of `count` bytes, at most `room`, none beyond most_x, most_y: 4 × how many, and the kind of the bytes behind
    them: 0 less than a packet; 1 bytes that are none, or more than one; 2 a packet in which a byte repeats its neighbour, so that more may
    come or the line be `quiet`; 3 any other packet.

    Each goes into `out`, from byte `at` on, as five bytes: 1 for a line or 0, x and y, high byte first. `before` is the
    last byte of the packet before, or −1. The text above says why which bytes are no packet.
    """
    found = 0
    first = 0
    while first + 6 <= count:
        code = int(data[first])
        check = int(data[first + 5])
        last = first + 6 == count
        spare = 256  # a twin of this value removed, the packet is another one
        if not last:
            spare = (2 * check - int(data[first + 6])) & 255
        what = int(judge_packet(data, first, before, spare))
        before = check
        if what == 1:
            return found + 1
        if what and last and quiet == 0:
            return found + 2
        index = first + 1
        first += 6
        if room == 0 or code < LINE or code > MOVE:
            return found + 3
        if int(data[index]) << 8 | int(data[index + 1]) > most_x:
            return found + 3
        if int(data[index + 2]) << 8 | int(data[index + 3]) > most_y:
            return found + 3
        out[at] = MOVE - code
        at += 1
        while index < first - 1:
            out[at] = data[index]
            at += 1
            index += 1
        room -= 1
        found += 4
    return found


class Plotter:
    binary = True  # 00 is a byte like others
    stored = None  # as Grbl's

    def __init__(self, gap_ms=5, jog_up=(0, 1), batch=None):
        """`gap_ms`: silence that ends a burst; `jog_up`: the direction, in axes, of UP (RIGHT is a quarter turn on);
        `batch`: a batch.Points of the link."""
        self.batch = batch
        self.words = None  # PacketWords, if options add some
        self.gap_ms = gap_ms
        up_x, up_y = jog_up
        self._jogs = {UP: (up_x, up_y), DOWN: (-up_x, -up_y), RIGHT: (up_y, -up_x), LEFT: (-up_y, up_x)}
        self._bytes = b""
        self._before = -1  # the last byte of the packet before: its echo is a twin too
        self._broken = False  # bytes are being dropped until the line is quiet
        self._why = errors.CHECKSUM  # they are
        self._since = 0  # when the oldest pending byte came
        self._latest = 0  # when the newest one came

    def take_batch(self, data, now_ms):
        """Keep `data`, and have the machine take the points at its start. Returns the answers to them."""
        if data:
            self._keep_bytes(data, now_ms)
        batch = self.batch
        count = 0
        while data and not self._broken and len(self._bytes) >= PACKET and (batch.begun or batch.open(batch)):
            batch.count = self._sift_bytes() >> 2
            if not batch.count:
                break
            self._cut_packets(batch.count, now_ms)
            count += batch.accept(batch)
        return b"n" * count

    def _sift_bytes(self):  # without variables of its own, so that the call takes nothing off the heap: see app.py
        """Call sift_points() for the batch. Without variables of its own, so that the call takes nothing off the heap: see app.py."""
        return sift_points(
            self._bytes, len(self._bytes), self._before, 0,
            self.batch.data, self.batch.offset, self.batch.room, self.batch.most_x, self.batch.most_y,
        )  # fmt: skip

    def feed(self, data, now_ms):
        """Return the commands in `data`, which may be empty: time alone ends bursts and drops torn packets."""
        if data:
            self._keep_bytes(data, now_ms)
        elif not self._broken and len(self._bytes) < PACKET and (not self._bytes or (now_ms - self._since) & COUNT_MASK < RESYNC_MS):
            return ()
        return self._packet_commands(now_ms)

    def _packet_commands(self, now_ms):
        """Return the commands in the bytes that are kept, and errors for those that time has shown to be torn."""
        commands = []
        quiet = (now_ms - self._latest) & COUNT_MASK >= self.gap_ms
        while not self._broken and len(self._bytes) >= PACKET:
            found = sift_points(self._bytes, len(self._bytes), self._before, quiet, self._bytes, 0, 0, 0, 0)
            if found == _HELD:
                return commands
            command = self._take_packet(now_ms) if found == _OTHER else None
            if command is None:
                self._broken = True
            else:
                commands.append(command)
        if self._broken and b"x\0\0\0\0x" in self._bytes:  # STOP
            self._drop_torn(self._why)
            self._before = HALT
            commands.append(Command(STOP))
        elif self._broken:
            self._bytes = self._bytes[1 - PACKET :]  # a STOP may have begun there
            if quiet:
                commands.append(self._drop_torn(self._why))
        elif self._bytes and (now_ms - self._since) & COUNT_MASK >= RESYNC_MS:
            if len(self._bytes) == 1 and self._bytes[0] == self._before:
                self._bytes = b""
                return commands
            commands.append(self._drop_torn(errors.BYTES_DROPPED))
        return commands

    def _keep_bytes(self, data, now_ms):
        """Keep bytes, and note when they came."""
        if not self._bytes:
            self._since = now_ms
        self._latest = now_ms
        self._bytes += data

    def _cut_packets(self, packets, now_ms):
        """Take `packets` packets out of the bytes."""
        end = PACKET * packets
        self._before = self._bytes[end - 1]
        self._bytes = self._bytes[end:]
        self._since = now_ms

    def _take_packet(self, now_ms):
        """Take a packet out of the bytes. Returns its Command; None if it is unknown."""
        data = self._bytes
        self._cut_packets(1, now_ms)
        code = data[0]
        x = data[1] << 8 | data[2]
        y = data[3] << 8 | data[4]
        if code in _SIMPLE:
            return Command(_SIMPLE[code])
        if code in self._jogs:
            return Command(JOG, target=self._jogs[code])
        if code == LINE or code == MOVE:
            return Command(POINT, target=(x, y), tool=code == LINE)
        if code == SET_SPEED or code == LINK:
            return Command(SPEED if code == SET_SPEED else HAND_OVER, value=x)
        if code == WORDS and self.words:
            return self.words.take_packet(data)
        self._why = errors.UNKNOWN_COMMAND
        return None

    def _drop_torn(self, error):
        """Drop the bytes. Returns the Command that says why."""
        self.drop_begun()
        self._why = errors.CHECKSUM
        return Command(BAD, error=error)

    def reply(self, event):
        """Return the bytes that tell the host of `event`; b"" if the language has no word for it."""
        command = event.command
        said = self.words.event_bytes(event) if self.words else None
        if said is not None:
            return said
        if command.kind == BAD:
            return b"" if command.error == errors.STOPPED else _RESEND
        if event.kind == FINISHED:
            return _ON_FINISHED.get(command.kind, b"")
        if event.kind != ACCEPTED:
            return b""
        if command.kind == STATUS:
            return status_bytes(event.value)
        return _ON_ACCEPTED.get(command.kind, b"")

    def push_bytes(self, event):
        """Return b"": the board never speaks unasked."""
        return b""

    def drop_begun(self):
        """Drop a packet that has come in part."""
        self._bytes = b""
        self._before = -1
        self._broken = False

    def drop(self, event):
        """Drop the bytes that have come so far, without a RESEND."""
        if self._bytes:
            self._broken = True
            self._why = errors.STOPPED
        return b""


STATES = ("idle", "run", "home", "jog", "alarm", "hold")
_SHOWN_AS = {"door": "hold", "check": "idle", "sleep": "alarm"}  # states that the language has no number for


def status_bytes(report):
    """Return STATUS's answer: `?` state error X Y drawn free checksum; X, Y and the counts of two bytes, high byte first, a position left of the
    origin as 0."""
    fields = [max(0, min(65535, steps)) for steps in report["position"][:2]]
    fields += [report["drawn"], min(report["free"], 65535)]
    state = _SHOWN_AS.get(report["state"], report["state"])
    body = struct.pack(">3B4H", ASK, STATES.index(state), report["error"], *fields)
    return body + bytes((sum(body) & 255,))
