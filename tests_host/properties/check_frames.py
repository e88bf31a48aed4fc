"""Frames: their bytes come once, in order, unchanged or not at all; a link without frames works as without this option."""

from draws import Random
from passo.protocols import HELLO_WIRE
from passo.protocols.frames import codec
from passo.protocols.frames.codec import ACK, AGAIN, CHECK, CLOSED, CUT, DATA, HEAD, FRAME_HELLO, LEAVE, REPORT, TAKEN, URGENT, WELCOME
from passo.protocols.frames.errors import FRAME_LATE
from passo.protocols.frames.line import FramedLine
from passo.protocols.frames.strays import Strays
from passo.protocols.grbl.lines import Lines
from passo.protocols.grbl.protocol import Grbl

CASES = {
    "check_frames_hold_any_bytes": (("seed", "seed"),),
    "check_no_damaged_frame_is_sound": (("seed", "seed"),),
    "check_plain_bytes_pass": (("seed", "seed"),),
    "check_bytes_come_once": (("seed", "seed"),),
    "check_a_late_frame_is_dropped": (("seed", "seed"),),
    "check_noise_amid_lines": (("seed", "seed"),),
    "check_noise_makes_no_line": (("seed", "seed"),),
    "check_bytes_of_packets": (("seed", "seed"),),
    "check_any_bytes_are_survived": (("seed", "seed"),),
}
RUNS = {"check_any_bytes_are_survived": 30}


class Wire:
    """The board's end of a serial line, with `clock` and a language that takes all."""

    def __init__(self):
        self.incoming = []
        self.noted = []  # numbers in the log
        self.sent = b""
        self.now_ms = 0
        self.protocol = self
        self.waiting = []
        self.line = FramedLine(self, self, 115_200, lambda: self.now_ms, self.noted.append)

    def any(self):
        return bool(self.incoming)

    def read(self):
        return self.incoming.pop(0) if self.incoming else b""

    def write(self, data):
        self.sent += data

    def put(self, *frames):
        """Return the bytes of these frames that the language reads."""
        return self.hear(codec.delimit_frames(*frames))

    def hear(self, data, piece=50):
        for at in range(0, len(data), piece):
            self.incoming.append(data[at : at + piece])
        heard = b""
        while True:
            data = self.line.read()
            heard += bytes(data)
            if not data and not self.incoming:
                return heard

    def said(self):
        """Return [(kind, number, ack, credit, data)] of the frames sent."""
        sent, self.sent = self.sent, b""
        return [frame_of(chunk) for chunk in sent.split(b"\0") if chunk]

    def opened(self):
        assert self.hear(HELLO_WIRE) == b""
        assert [frame[0] for frame in self.said()] == [WELCOME]
        return self


def frame_of(chunk):
    data = bytearray(chunk)
    assert codec.is_sound(data, 0, len(data)), chunk
    return codec.parse_header(data, 0) + (bytes(data[HEAD : len(data) - CHECK]),)


def check_frames_hold_any_bytes(seed):
    random = Random(seed)
    data = random.bytes(random.between(0, codec.MOST))
    if random.between(0, 1):
        data = bytes([byte & 1 for byte in data])
    fields = random.between(1, 15), random.between(0, 4095), random.between(0, 4095), random.between(0, 15)
    made = codec.frame(fields[0], fields[1], fields[2], fields[3], data)
    assert b"\0" not in made and len(made) <= codec.LONGEST
    assert frame_of(made) == fields + (data,)


def check_no_damaged_frame_is_sound(seed):
    """One to three bytes lost, doubled or flipped."""
    random = Random(seed)
    made = codec.frame(DATA, random.between(0, 4095), 0, 15, random.bytes(random.between(0, codec.MOST)))
    damaged = made
    for _ in range(random.between(1, 3)):
        at = random.between(0, len(damaged) - 1)
        middle = random.choice((b"", damaged[at : at + 1] * 2, bytes((damaged[at] ^ 1 << random.between(0, 7),))))
        damaged = damaged[:at] + middle + damaged[at + 1 :]
    for chunk in damaged.split(b"\0"):
        assert chunk == made or not codec.is_sound(bytearray(chunk), 0, len(chunk))


def check_hello():
    """The bytes of HELLO are a frame, and none of them is anything to any language."""
    assert frame_of(HELLO_WIRE[1:-1])[0] == FRAME_HELLO
    for byte in HELLO_WIRE:
        assert byte < 0x20 and byte not in (3, 6, 9, 10, 13, 0x11, 0x13, 0x18, 0x1B)


def check_plain_bytes_pass(seed):
    """Until HELLO comes whole a link is what it was: all bytes pass, in order, and answers go out as they are."""
    random = Random(seed)
    wire = Wire()
    data = b""
    for _ in range(random.between(1, 8)):
        data += random.choice((random.bytes(random.between(0, 40)), HELLO_WIRE[: random.between(1, 15)], b"\0"))
    at = data.find(HELLO_WIRE)
    data = data if at < 0 else data[:at]
    heard = wire.hear(data, random.between(1, 60))
    wire.now_ms += 20
    assert heard + bytes(wire.line.read()) == data
    wire.line.write(b"ok\r\n")
    assert wire.sent == b"ok\r\n"


def check_hello_in_the_middle():
    """Bytes before it go to the language; after it only those in frames do."""
    for piece in (1, 7, 60):
        wire = Wire()
        assert wire.hear(b"G1X1\n" + HELLO_WIRE + b"~!G1X9\n" + codec.delimit_frames(codec.frame(DATA, 0, 0, 15, b"M3\n")), piece) == b"G1X1\nM3\n"
        assert wire.said()[0][0] == WELCOME


def check_a_line_begun_is_not_gone_on_with():
    """Neither what was begun before a session by its first line, nor what it leaves by plain text: G91 and G0X10 are no line."""
    for urgent in range(2):
        lines = Lines()
        wire = Wire()
        wire.protocol = lines
        wire.line = FramedLine(wire, wire, 115_200, lambda: wire.now_ms, wire.noted.append)
        lines.take_bytes(wire.hear(b"G90\nG91"))
        lines.take_bytes(wire.hear(HELLO_WIRE))
        if urgent:
            assert wire.put(codec.frame(URGENT, 0, 0, 15, b"~")) == b"~"
        lines.take_bytes(wire.put(codec.frame(DATA, 0, 0, 15, b"G0X10\nG0X20\nG91")))
        assert [lines.next_line() for _ in range(3)] == [b"G90", b"G0X10", b"G0X20"] and lines.is_amid_line()
        wire.put(codec.frame(LEAVE, urgent, 0, 15))
        assert not lines.is_amid_line()
        lines.take_bytes(wire.hear(b"G0X30\n"))
        assert lines.next_line() == b"G0X30" and not lines.has_lines()


def check_bytes_come_once(seed):
    """Frames repeated, missing, overlapping: the language reads the bytes sent, each once."""
    random = Random(seed)
    wire = Wire().opened()
    text = random.bytes(3000)
    heard = b""
    known = 0  # the board has everything before
    while known < len(text):
        at = max(0, known - random.between(0, 300)) if random.between(0, 3) else known + random.between(0, 200)
        data = text[at : at + random.between(1, codec.MOST)]
        heard += wire.put(codec.frame(DATA, at % 4096, 0, 15, data))
        if at <= known:
            known = max(known, at + len(data))
        wire.now_ms += 30
        answers = wire.said()
        assert [frame[0] for frame in answers] == [AGAIN if at > known else ACK] or not data
        assert all([frame[2] == known % 4096 for frame in answers])
    assert heard == text


def check_urgent_frames_count_once():
    wire = Wire().opened()
    toggle = codec.frame(URGENT, 0, 0, 15, b"\x9e")
    assert wire.put(toggle, toggle) == b"\x9e" and wire.put(toggle) == b""
    assert [(frame[0], frame[1]) for frame in wire.said()] == [(TAKEN, 0)] * 3
    assert wire.put(codec.frame(URGENT, 2, 0, 15, b"~")) == b"", "one is missing"
    assert wire.put(codec.frame(URGENT, 1, 0, 15, b"!")) == b"!"


def check_cut():
    """Bytes numbered before a CUT that come after it are not read."""
    wire = Wire().opened()
    assert wire.put(codec.frame(DATA, 0, 0, 15, b"G1X1\n")) == b"G1X1\n"
    assert wire.put(codec.frame(CUT, 0, 0, 15, bytes((0, 15)) + b"\x18")) == b"\x18"
    assert wire.put(codec.frame(DATA, 5, 0, 15, b"G1X2\nG1X3\n")) == b""
    assert wire.put(codec.frame(DATA, 15, 0, 15, b"G1X4\n")) == b"G1X4\n"
    assert wire.put(codec.frame(CUT, 1, 0, 15, b"")) == b"", "it has no number"


def check_reports():
    """The board asks itself at the period of the REPORT frame, and only while the host takes the answers."""
    wire = Wire().opened()
    wire.put(codec.frame(REPORT, 0, 0, 15, bytes((0, 250)) + b"?"))
    asked = 0
    for _ in range(1000):
        wire.now_ms += 1
        asked += bytes(wire.line.read()) == b"?"
    assert asked == 4
    wire.put(codec.frame(REPORT, 1, 0, 15, bytes((0, 0))))
    wire.now_ms += 1000
    assert wire.line.read() == b""


def check_answers_are_repeated():
    """Until they are acknowledged: asked for, or late; then no more."""
    wire = Wire().opened()
    wire.line.write(b"ok\r\n")
    first = wire.said()
    assert first == [(DATA, 0, 0, 4, b"ok\r\n")]
    wire.put(codec.frame(AGAIN, 0, 0, 15))
    assert wire.said() == first
    wire.now_ms += 100
    wire.line.read()
    assert wire.said() == first
    wire.put(codec.frame(ACK, 0, 4, 15))
    wire.now_ms += 1000
    wire.line.read()
    assert wire.said() == []


def check_lost_answers_end_the_session():
    """A host that takes no answers costs a bounded buffer; it gets CLOSED, and moves nothing until it begins anew."""
    wire = Wire().opened()
    for _ in range(2000):
        wire.line.write(b"ok\r\n")
    wire.said()
    assert wire.put(codec.frame(DATA, 0, 0, 15, b"G1X1\n")) == b""
    assert [frame[0] for frame in wire.said()] == [CLOSED]
    wire.opened()
    assert wire.put(codec.frame(DATA, 0, 0, 15, b"G1X1\n")) == b"G1X1\n"


def check_credit_follows_what_waits():
    """While commands wait there is little credit, for STOP and STATUS; if many do, none. It is given back unasked."""
    for count, credit in ((1, 1), (31, 1), (32, 0), (60, 0)):
        wire = Wire().opened()
        wire.waiting += [1] * count
        wire.put(codec.frame(DATA, 0, 0, 15, b"a"))
        assert wire.said()[-1][3] == credit
        while wire.waiting:
            wire.waiting.pop()
        wire.line.read()
        assert [(frame[0], frame[3]) for frame in wire.said()] == [(ACK, 4)]


def check_leave():
    """The host takes its leave: the link is plain again, and may be asked again."""
    wire = Wire().opened()
    wire.put(codec.frame(LEAVE, 0, 0, 15))
    assert [frame[0] for frame in wire.said()] == [TAKEN]
    assert wire.hear(b"?") == b"?"
    wire.line.write(b"<Idle>")
    assert wire.sent == b"<Idle>"
    wire.sent = b""
    wire.opened()


def left(random):
    """A wire whose host has taken its leave, or has said nothing behind WELCOME."""
    wire = Wire().opened()
    if random.between(0, 1):
        wire.put(codec.frame(LEAVE, 0, 0, 15))
    else:
        wire.now_ms += 1000
        assert wire.hear(b"") == b""
    wire.sent = b""
    return wire


def check_a_late_frame_is_dropped(seed):
    """Whole, damaged or cut off anywhere, in pieces: no byte of it comes to the language, what stands around it does, and the log says so."""
    random = Random(seed)
    wire = left(random)
    for _ in range(3):
        frames = [codec.frame(DATA, random.between(0, 4095), 0, 15, b"G1X%d\nG1Y%d\n" % (n, n)) for n in range(random.between(1, 3))]
        late = bytearray(codec.delimit_frames(*frames))
        if random.between(0, 1):
            late = late[: random.between(2, len(late))]
        if random.between(0, 1):
            late[random.between(1, len(late) - 1)] = random.between(1, 255)
        assert wire.hear(b"G1Z1\n" + bytes(late), random.between(1, 64)) == b"G1Z1\n", late
        wire.now_ms += 100
        assert wire.hear(b"") == b"" and set(wire.noted) == {FRAME_LATE}
        wire.noted.clear()
        wire.now_ms += 900
        assert wire.hear(b"G1Z2\n") == b"G1Z2\n"
    assert wire.opened().hear(b"") == b""


def check_noise_amid_lines(seed):
    """A 00 of noise on a link that has left frames costs the lines of one frame's length at most, and the one that these end in is
    refused; on a link that never spoke frames only its own line."""
    random = Random(seed)
    lines = b"".join([b"G1X%dY%d\n" % (n, n) for n in range(60)])
    at = random.between(0, 200)
    noisy = lines[:at] + b"\0" + lines[at:]
    assert Wire().hear(noisy, 64) == noisy
    wire = left(random)
    heard = wire.hear(noisy, 64)
    assert heard == lines[:at] + b"\0" + lines[at + codec.LONGEST :] and wire.noted == [FRAME_LATE]


class Language:
    """Grbl as a line sees it: it takes lines, and says if it is amid one."""

    is_amid = Grbl.is_amid

    def __init__(self):
        self._lines = Lines()

    def drop_begun(self):
        self._lines.drop_begun()

    def take(self, data):
        """The lines that end in `data`."""
        lines = self._lines
        assert lines.take_bytes(data)
        while lines.has_lines():
            yield lines.next_line()


def check_noise_makes_no_line(seed):
    """Bytes 00 anywhere between plain lines, with pauses or without: each line that is understood is one that was sent, as it was sent. Never
    is the beginning of one gone on with by the end of another, on a link that has left frames and on one that never spoke them."""
    random = Random(seed)
    for framed in (True, False):
        wire = left(random) if framed else Wire()
        wire.protocol = language = Language()
        if framed:
            wire.line._strays = Strays(False, language.is_amid)
        sent = [b"G1X%d%dY%d" % (n, n, n) for n in range(random.between(3, 40))]
        text = b"\n".join(sent) + b"\n"
        for _ in range(random.between(1, 4)):
            at = random.between(0, len(text))
            text = text[:at] + b"\0" + text[at:]
        heard = []
        while text:
            count = random.between(1, 60)
            heard += language.take(wire.hear(text[:count]))
            text = text[count:]
            if random.between(0, 3) == 0:
                wire.now_ms += 150
                heard += language.take(wire.hear(b""))
        wire.now_ms += 150
        heard += language.take(wire.hear(b""))
        assert not [line for line in heard if b"\0" not in line and line not in sent], heard
        if not framed:
            assert len(heard) == len(sent), "each is answered"


def check_bytes_of_packets(seed):
    """A language in which 00 is a byte like others reads all of them, but for sound frames."""
    random = Random(seed)
    wire = Wire()
    wire.binary = True
    wire.opened().put(codec.frame(LEAVE, 0, 0, 15))
    packets = bytes([byte if byte > 99 else 0 for byte in random.bytes(120)])
    heard = wire.hear(packets, random.between(1, 64))
    wire.now_ms += 4
    assert heard + wire.hear(b"") == packets
    assert wire.put(codec.frame(DATA, 7, 0, 15, packets[:60])) == b""
    wire.now_ms += 4
    assert wire.hear(b"").strip(b"\0") == b"" and wire.noted == [FRAME_LATE]


def check_any_bytes_are_survived(seed):
    """Noise, damaged frames and frames of any kind and number: nothing is raised, what is read lay in a sound frame, and the
    session goes on."""
    random = Random(seed)
    wire = Wire().opened()
    for _ in range(60):
        made = codec.frame(random.between(1, 15), random.between(0, 4095), random.between(0, 4095), random.between(0, 15), random.bytes(random.between(0, 30)))
        wire.put(made)
        wire.hear(random.bytes(random.between(0, 300)), random.between(1, 128))
        wire.now_ms += random.between(0, 100)
        wire.line.write(random.bytes(random.between(0, 20)))
    wire.sent = b""
    if wire.hear(HELLO_WIRE) == b"" and wire.sent[:1] == b"\0":
        welcome = [frame for frame in wire.said() if frame[0] == WELCOME][0]
        wire.said()
        heard = wire.put(codec.frame(DATA, welcome[2], 0, 15, b"G1X1\n"))
        assert heard == b"G1X1\n", heard
