"""Two directions of a wire that loses, doubles and flips bytes, one at a time and in bursts, and the programs at both its ends.

    pair = Pair(seed, 0.01)                 # a FramedLine with a language of lines, and a FramedPort, at 115 200 baud
    pair.stream(10_000)                     # raises AssertionError if a line is lost, doubled, changed or out of order
    pair.wires[0].faults, pair.recoveries, pair.now_ms

Time is virtual: a tick is a millisecond.
"""

import random

from host_tools.clients.frames import FramedPort
from passo.protocols.frames.codec import NUMBERS
from passo.protocols.frames.line import FramedLine

BAUD = 115_200
_BYTES_MS = BAUD / 10_000
_BURST = 20  # bytes, on average
_UNDER_WAY = 900  # bytes of lines that are not answered
_LONGEST_MS = 1000  # of a jump of time: older bytes have come


def damaged(dice, data):
    """`data` with one byte lost, doubled or flipped."""
    at = dice.randrange(len(data))
    kind = dice.choice(("lost", "doubled", "flipped"))
    if kind == "lost":
        return data[:at] + data[at + 1 :]
    if kind == "doubled":
        return data[: at + 1] + data[at:]
    return data[:at] + bytes([data[at] ^ dice.randint(1, 255)]) + data[at + 1 :]


class NoisyWire:
    """One direction: bytes come a while after they have been put, in order."""

    def __init__(self, seed, share):
        """`share` of the bytes get a fault: half of them alone, half in bursts."""
        self.random = random.Random(seed)
        self.share = share
        self.faults = 0
        self.sent = 0
        self.fault_ms = None  # of the last one that nobody has recovered from
        self._waiting = bytearray()
        self._free = 0.0
        self._burst = 0
        self._next = self._gap()

    def _gap(self):
        """Bytes to the next single fault or burst."""
        return int(self.random.expovariate(self.share * (0.5 + 0.5 / _BURST))) if self.share else 1 << 60

    def set(self, share):
        """From now on."""
        self.share = share
        self._burst = 0
        self._next = self._gap()

    def put(self, data):
        self.sent += len(data)
        self._waiting += data

    def drop(self):
        """Drop the bytes on their way."""
        self._waiting.clear()
        self._free = 0.0

    def take(self, now_ms):
        """Return the bytes that come within this millisecond."""
        if not self._waiting:
            self._free = 0.0
            return b""
        self._free += _BYTES_MS
        count = min(int(self._free), len(self._waiting))
        self._free -= count
        data = self._waiting[:count]
        del self._waiting[:count]
        if self._next >= count and not self._burst:
            self._next -= count
            return bytes(data)
        return self._damaged(data, now_ms)

    def _damaged(self, data, now_ms):
        out = bytearray()
        for byte in data:
            if self._burst:
                self._burst -= 1
            elif self._next:
                self._next -= 1
                out.append(byte)
                continue
            else:
                self._next = self._gap()
                if self.random.random() < 1 / (_BURST + 1):
                    self._burst = int(self.random.expovariate(1 / _BURST))
            self.faults += 1
            self.fault_ms = now_ms
            kind = self.random.randrange(3)
            if kind == 1:
                out += bytes((byte, byte))
            elif kind == 2:
                out.append(byte ^ 1 << self.random.randrange(8))
        return bytes(out)


class Cable:
    """Both directions between the PC and link `link` of a VirtualMachine."""

    def __init__(self, seed, link=None):
        self.wires = [NoisyWire(f"{seed} 0", 0), NoisyWire(f"{seed} 1", 0)]  # to the board, and from it
        self.plugged = True
        self.arrived = b""  # at the PC
        self._link = link
        self._at_ms = 0

    def set(self, share):
        for wire in self.wires:
            wire.set(share)

    def faults(self):
        return sum([wire.faults for wire in self.wires])

    def renew(self, now_ms):
        """A quiet cable, with nothing on it."""
        self._at_ms = int(now_ms)
        self.arrived = b""
        for wire in self.wires:
            wire.drop()
        self.plugged = True
        self.set(0)

    def carry(self, machine, now_ms):
        """Carry the bytes up to `now_ms`, in both directions."""
        self._at_ms = max(self._at_ms, int(now_ms) - _LONGEST_MS)
        said = machine.take(self._link)
        if self.plugged:
            self.wires[1].put(said)
        while self._at_ms < int(now_ms):
            self._at_ms += 1
            data = self.wires[0].take(self._at_ms)
            if self.plugged:
                machine.send(data, self._link)
                self.arrived += self.wires[1].take(self._at_ms)


class _Language:
    """Answers each line, by its own text unless `answer` is another."""

    waiting = ()

    def __init__(self, answer):
        self.protocol = self
        self.part = b""
        self.lines = []
        self._answer = answer

    def space(self):
        return 1024 - len(self.part)

    def feed(self, data):
        *lines, self.part = (self.part + bytes(data)).split(b"\n")
        self.lines += lines
        return b"".join([(self._answer or line) + b"\n" for line in lines])


class _Board:
    """The board's end of the wires, as a serial line."""

    def __init__(self, pair):
        self._pair = pair

    def read(self):
        data, self._pair.arrived[0] = self._pair.arrived[0], b""
        return data

    def any(self):
        return bool(self._pair.arrived[0])

    def write(self, data):
        self._pair.wires[1].put(data)


class _Host:
    """The PC's end, as a pyserial port: while it waits for bytes a millisecond passes."""

    baudrate = BAUD
    timeout = 0.05

    def __init__(self, pair):
        self._pair = pair

    @property
    def in_waiting(self):
        return len(self._pair.arrived[1])

    def read(self, size):
        if not self.in_waiting:
            self._pair.tick()
        data, self._pair.arrived[1] = self._pair.arrived[1], b""
        return data

    def write(self, data):
        self._pair.wires[0].put(data)


class Pair:
    def __init__(self, seed=0, share=0.0, answer=b""):
        self.now_ms = 0
        self.wires = [NoisyWire(seed, 0), NoisyWire(seed + 1, 0)]
        self.arrived = [b"", b""]
        self.recoveries = []  # ms from the end of a fault to the next new byte in order
        self.frames = 0  # that have come whole, at the board
        self._language = _Language(answer)
        self._line = FramedLine(self._language, _Board(self), BAUD, lambda: self.now_ms, lambda number: None)
        self._count_frames()
        self.port = self.opened()
        assert self.port.begin(1)
        for wire in self.wires:
            wire.set(share)

    def opened(self):
        """The port of another program on the PC, which has not begun."""
        return FramedPort(_Host(self), lambda: self.now_ms)

    def _count_frames(self):
        understand = self._line._do_frame

        def counted(begin, end):
            self.frames += 1
            return understand(begin, end)

        self._line._do_frame = counted

    def tick(self):
        self.now_ms += 1
        for side in (0, 1):
            self.arrived[side] += self.wires[side].take(self.now_ms)
        while True:
            data = self._line.read()
            if not data:
                return
            wire = self.wires[0]
            if wire.fault_ms is not None:
                self.recoveries.append(self.now_ms - wire.fault_ms)
                wire.fault_ms = None
            self._line.write(self._language.feed(data))

    def stream(self, frames, limit_ms=1 << 40):
        """Send lines until `frames` frames in all have come to the board."""
        wanted, port = [], self.port
        sent = under_way = heard = 0
        text = b""
        end_ms = self.now_ms + limit_ms
        self._language.lines.clear()
        while self.frames < frames or heard < sent:
            assert self.now_ms < end_ms, "no end"
            while under_way < _UNDER_WAY and self.frames < frames:
                line = b"G1X%d.%03dY%d" % (sent % 300, sent % 1000, sent * 7919 % 100_003)
                wanted.append(line)
                port.write(line + b"\n")
                under_way += len(line) + 1
                sent += 1
            *lines, text = (text + port.read(4096)).split(b"\n")
            for line in lines:
                assert line == (self._language._answer or wanted[heard]), (line, wanted[heard])
                under_way -= len(wanted[heard]) + 1
                heard += 1
        assert self._language.lines == wanted
        return sum(len(line) + 1 for line in wanted)
