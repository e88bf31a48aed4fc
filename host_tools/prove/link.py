"""Rows of `passo prove` about the link: bytes, questions, lines or points, over the port that it runs on."""

import binascii
import random
import re
import statistics

from host_tools.failure import Failure
from host_tools.language import _
from host_tools.prove.row import number_text

BYTES = 16384
SLICE = 64
ASKS = 200
LINES = 800
POINTS = 400
WINDOW = 127
QUIET_MS = 700
FRAMED, SPOILED, FRAMES_S = 200, 300, 3
_ANSWER = re.compile(rb"(?:ok|error:\d+)\r\n")


def link(proof):
    """Yield the rows of the link: bytes lost, then answer times and rate in the language of the first link, over USB."""
    first = proof.raw["links"][0]
    language = first["protocol"]
    axes = [dict(axis, max_mm_min=30_000, accel_mm_s2=300_000) for axis in proof.raw["axes"]]
    link = {"name": "pc", "port": "usb", "protocol": language}
    link.update({key: first[key] for key in ("idle_gap_ms",) if key in first})
    proof.begin("make", {"links": [link], "axes": axes})
    yield from bytes_through(proof)
    proof.begin("make", {"links": [link], "axes": axes})  # make the line anew: it must check the console again, because the REPL has read from it
    if language == "grbl":
        yield from grbl_link(proof)
        if first.get("frames") or proof.frozen:
            proof.begin("make", {"links": [{**link, "frames": True}], "axes": axes})
            yield measure_frames(proof)
    elif language == "plotter":
        yield from plotter_link(proof)


def bytes_through(proof):
    """Yield a row: bytes lost or changed of BYTES random ones sent to the board and as many sent back."""
    board = proof.board
    data = random.Random(37).randbytes(BYTES)
    board.start(f"echo_bytes({BYTES})")
    board.wait_s(0.05)
    for at in range(0, BYTES, SLICE):
        board.write(data[at : at + SLICE])
        board.wait_s(0.0005)
    said = board.expect(b"\n")
    came, total = (int(each) for each in said.split(b"took", 1)[1].split())
    rest = board.expect(b"\x04")[:-1]
    board.check_for_error()
    lost = max(BYTES - came, 0) + max(BYTES - len(rest), 0)
    changed = not lost and (total != binascii.crc32(data) or rest != bytes(range(128, 256)) * (BYTES // 128))
    found = _("{} to the board, {} back", BYTES - came, BYTES - len(rest)) if not changed else _("none, but some were changed")
    yield proof.judge("bytes_lost", lost or changed, found=found)


def grbl_link(proof):
    """Yield rows: answer time to `?` at rest in ms, lines a second with late words, and answer time to `?` while lines stream."""
    board = proof.board
    board.start(f"serve({QUIET_MS})")
    board.expect(b"ready\r\n")
    time_answer(proof, b"$X\n", b"ok")
    waits = sorted(time_answer(proof, b"?", b">\r\n") for _again in range(ASKS))
    yield proof.judge("ask_ms", statistics.median(waits) * 1000, found=_("{} ms, p99 {}", number_text(statistics.median(waits) * 1000), number_text(waits[-3] * 1000)))
    lines_s, asked = stream_lines(proof, chord_lines(LINES, len(proof.raw["axes"])))
    proof.timings["asks"] = [each * 1000 for each in asked]
    board.expect(b"served", 30)
    late = int(board.wait_for_end().split()[0])
    yield proof.judge("lines_s", lines_s, late=late)
    asked.sort()
    yield proof.judge("ask99_ms", asked[int(len(asked) * 0.99) - 1] * 1000, found=_("{} ms, median {}", number_text(asked[int(len(asked) * 0.99) - 1] * 1000), number_text(statistics.median(asked) * 1000)))


def measure_frames(proof):
    """Return a Row: lines lost when they go in frames over a wire that spoils bytes on their way to the board."""
    from host_tools.clients.frames import FramedPort

    board = proof.board
    board.start(f"serve({QUIET_MS})")
    board.expect(b"ready\r\n")
    wire = SpoiledWire(board)
    port = FramedPort(wire, lambda: round(board.now_s() * 1000))
    if not port.begin(FRAMES_S):
        raise Failure("the board does not answer in frames")
    lines = [b"$X\n", *chord_lines(FRAMED, len(proof.raw["axes"]))]
    said, sent, begun = b"", 0, board.now_s()
    while (answered := len(_ANSWER.findall(said))) < len(lines) and board.now_s() - begun < 30:
        if sent < len(lines) and sent - answered < 8:
            port.write(lines[sent])
            sent += 1
        said += port.read(256)
        if b"\nserved" in said:  # it has waited in vain
            said, _end, rest = said.partition(b"\nserved")
            board.heard = b"served" + rest + board.heard
            break
    board.wait_s(QUIET_MS / 1000 + 0.5)
    board.expect(b"served", 30)
    board.wait_for_end()
    lost = len(lines) - said.count(b"ok\r\n")
    return proof.judge("framed_lost", lost, found=_("{} of {}, though {} bytes were spoiled", lost, len(lines), wire.spoiled))


class SpoiledWire:
    """A serial port over a board that spoils one byte in SPOILED of those written."""

    baudrate = timeout = None

    def __init__(self, board):
        self._board, self._written, self.spoiled = board, 0, 0

    @property
    def in_waiting(self):
        self._board.heard += self._board.read()
        return len(self._board.heard)

    def read(self, size):
        """Return up to `size` bytes from the board, b"" after 0.5 ms without any."""
        if not self.in_waiting:
            self._board.wait_s(0.0005)
        data = self._board.take_output()
        self._board.heard = data[size:]
        return data[:size]

    def write(self, data):
        """Send bytes with a bit flipped in each SPOILED-th, but for the first write, and count the flips in `spoiled`."""
        data = bytearray(data)
        for at in range(-self._written % SPOILED, len(data), SPOILED):
            if self._written:  # HELLO comes whole
                data[at] ^= 0x10
                self.spoiled += 1
        self._written += len(data)
        self._board.write(bytes(data))


def plotter_link(proof):
    """Yield rows: answer time to REQUEST in ms, and packets a second with 32 under way."""
    from passo.protocols.plotter.host import PACKET

    board = proof.board
    board.start(f"serve({QUIET_MS})")
    board.expect(b"ready\r\n")
    waits = sorted(time_answer(proof, b"r\0\0\0\0r", b"k") for _again in range(ASKS))
    yield proof.judge("ask_ms", statistics.median(waits) * 1000)
    from host_tools.emulator.traffic import move_packets

    data = move_packets(400)
    begun, sent, answered = board.now_s(), 0, 0
    while answered < 400 and board.now_s() - begun < 30:
        while sent < 400 and sent - answered < 32:
            board.write(data[sent * PACKET : (sent + 1) * PACKET])
            sent += 1
        board.wait_s(0.0002)
        answered += board.take_output().count(b"n")
    took = board.now_s() - begun
    board.expect(b"served", 30)
    board.wait_for_end()
    yield proof.judge("packets_s", answered / took)


def time_answer(proof, question, answer):
    """Return the seconds from a question to its answer. Raises Failure after 5 s."""
    board = proof.board
    board.take_output()
    begun = board.now_s()
    board.write(question)
    while answer not in board.heard:
        if board.now_s() - begun > 5:
            raise Failure("{!r} was not answered within five seconds", question.decode("latin-1"))
        board.wait_s(0.0002)
        board.heard += board.read()
    return board.now_s() - begun


def stream_lines(proof, lines):
    """Stream lines; return (lines a second of the last three quarters, [the seconds that each `?` waited])."""
    board = proof.board
    board.take_output()
    under_way, said, asked, pending, next_ask = [], b"", [], None, board.now_s()
    sent = answered = 0
    begun = start = board.now_s()
    while answered < len(lines):
        while sent < len(lines) and sum(under_way) + len(lines[sent]) <= WINDOW:
            board.write(lines[sent])
            under_way.append(len(lines[sent]))
            sent += 1
        now = board.now_s()
        if pending is None and now >= next_ask:
            board.write(b"?")
            pending, next_ask = now, now + 0.0093
        board.wait_s(0.0002)
        *whole, said = (said + board.take_output()).split(b"\r\n")
        for line in whole:
            if line == b"ok" or line.startswith(b"error"):
                answered += 1
                under_way.pop(0)
                if answered == len(lines) // 4:
                    start = board.now_s()
                if line != b"ok":
                    raise Failure("a line was answered by {}: bytes are lost or changed on the way", line.decode())
            elif line.startswith(b"<") and pending is not None:
                asked.append(board.now_s() - pending)
                pending = None
        if board.now_s() - begun > 60:
            raise Failure("the stream stopped: {} of {} lines answered. Bytes are lost on the way", answered, len(lines))
    return (len(lines) - len(lines) // 4) / (board.now_s() - start), asked


def chord_lines(count, axes):
    """Return lines of 0.2 mm, in space or in a plane."""
    from host_tools.emulator.gcode import LINE_BYTES, chords

    start, data = chords(0.2)
    lines = [line.rstrip() + b"\n" for line in data.splitlines()]
    head = [b"G21G90G94\n", b"G92X%.3fY50Z-20\n" % start, b"G1F29400\n"]
    made = head + (lines * (count // len(lines) + 1))[:count]
    return made if axes > 2 else [re.sub(rb"Z[-.\d]+", b"", line) for line in made]
