"""Frames over a wire that damages them, the page that tells of them, and programs written from it."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from framed_job import MachineAndClient
from host_tools import interpreter
from host_tools.clients.frames import OFFER_S, SURE_S
from host_tools.resources import ROOT
from noisy_wire import Pair
from passo.protocols import HELLO_WIRE
from passo.protocols.frames import codec

PAGE = ROOT / "docs" / "reference" / "languages" / "frames.md"
REFERENCE = ROOT / "docs" / "reference" / "languages" / "frames_client.py"
RECOVERY_MS = 100
MILLION = 1_000_000


def vectors():
    rows = re.findall(r"^\| `([0-9a-f ]+)` \| (\w+) \| (\d+) \| (\d+) \| (\d+) \| (?:`([0-9a-f ]+)`)? ", PAGE.read_text(), re.MULTILINE)
    return [(bytes.fromhex(wire), kind, int(number), int(ack), int(credit), bytes.fromhex(data)) for wire, kind, number, ack, credit, data in rows]


def test_the_page_has_the_frames():
    kinds = {getattr(codec, kind) for _, kind, *_ in vectors()}
    assert len(vectors()) == 12 and kinds == set(range(codec.WELCOME, codec.CLOSED + 1))
    for wire, kind, number, ack, credit, data in vectors():
        assert codec.delimit_frames(codec.frame(getattr(codec, kind), number, ack, credit, data)) == wire
        chunk = bytearray(wire[1:-1])
        assert codec.is_sound(chunk, 0, len(chunk))
        assert codec.parse_header(chunk, 0) == (getattr(codec, kind), number, ack, credit)
        assert bytes(chunk[codec.HEAD : -codec.CHECK]) == data
    assert HELLO_WIRE.hex(" ") in PAGE.read_text()


def test_the_reference_client_is_short():
    assert len(REFERENCE.read_text().splitlines()) <= 150


def percentile(values, share):
    return sorted(values)[int(share * len(values))]


def test_a_noisy_wire_loses_no_line():
    pair = Pair(seed=11, share=0.01)
    pair.stream(20_000)
    assert pair.wires[0].faults > 3000 and pair.wires[1].faults > 3000
    assert percentile(pair.recoveries, 0.99) <= RECOVERY_MS


def spoilt(wire, count):
    """A byte of each of the next `count` writes is flipped."""
    put, left = wire.put, [count]

    def spoil(data):
        if left[0]:
            left[0] -= 1
            data = data[:5] + bytes((data[5] ^ 64,)) + data[6:]
        put(data)

    wire.put = spoil


@pytest.mark.parametrize("side", [0, 1])
def test_a_bad_wire_is_not_taken_for_a_board_without_frames(side):
    """HELLO, or WELCOME, is damaged again and again."""
    pair = Pair()
    pair.port._leave_session()
    port = pair.opened()
    spoilt(pair.wires[side], 6)
    assert port.begin(SURE_S if side == 0 else OFFER_S, side == 1)
    port.write(b"G1X1\n")
    while b"\n" not in port.read(10):
        assert pair.now_ms < 2000


def test_a_session_that_was_left_open_is_ended_on_a_bad_wire():
    pair = Pair()
    pair.port.write(b"G1\n")
    while not pair.port.read(10):
        pass
    port = pair.opened()
    send, left = port._send_frame, [4]

    def lost(kind, *rest):
        if kind != codec.LEAVE or not left[0]:
            return send(kind, *rest)
        left[0] -= 1

    port._send_frame = lost
    assert port.begin(OFFER_S) and not left[0]
    port._send_frame = lambda kind, *rest: None if kind == codec.LEAVE else send(kind, *rest)
    port.write(b"G1\n")
    while not port.read(10):
        pass
    other = pair.opened()
    other._leave_session = lambda: None
    with pytest.raises(OSError, match="another program"):
        other.begin(OFFER_S)


def kind_of(wire):
    chunk = bytearray(wire.strip(b"\0"))
    assert codec.is_sound(chunk, 0, len(chunk))
    return codec.parse_header(chunk, 0)[0]


def test_nothing_is_sent_behind_leave():
    """The board that has taken it is plain, and a byte of AGAIN or ACK may be grbl's `~` or its door."""
    for seed in range(100):
        pair = Pair(seed, 0.02)
        pair.port.report(10, b"<Idle|MPos:3.897,3.616,0.000|FS:0,0>\n")
        until_ms = pair.now_ms + 200
        while pair.now_ms < until_ms:
            pair.port.read(100)
        said = []
        pair.wires[0].put = said.append
        pair.port._leave_session()
        assert [kind_of(wire) for wire in said] == [codec.LEAVE], seed


def test_questions_acknowledge_what_the_board_has_said():
    """A program that asks all the time needs no other acknowledgement."""
    pair = Pair()
    for number in range(30):
        pair.port.write(b"G1X%d\n" % number)
    while pair._line._sender.kept or pair.port._sender.kept:
        if not pair.port._urgents:
            pair.port.urgent(b"?")
        assert pair.port.in_waiting < 400 and pair.now_ms < 600


def test_credit_is_asked_for_if_the_word_of_it_is_lost():
    """The board has no room, then it has; its ACK is lost, and nothing else is under way."""
    pair = Pair()
    pair._language.space = lambda: 0
    pair._line._space = pair._language.space
    pair.now_ms += 10_000  # in which nobody wants anything
    pair.port.write(b"G1X1\n")
    while not pair.port.read(10):
        pass
    pair.port.write(b"G1X2\n")
    for _ in range(100):
        pair.port.read(10)
    assert not pair.port._sender.flying and pair.port._sender.kept
    pair._line._space = lambda: 1024
    wire, put = pair.wires[1], pair.wires[1].put
    wire.put = lambda data: None
    pair.tick()
    wire.put = put
    until_ms = pair.now_ms + 500
    while not pair.port.read(10):
        assert pair.now_ms < until_ms


def test_a_program_that_has_not_looked_for_a_while_has_not_lost_the_board():
    """Its last line still waits for its acknowledgement."""
    pair = Pair()
    pair.port.write(b"G1X1\n")
    pair.port.urgent(b"?")
    pair.now_ms += 60_000
    pair.port.write(b"G1X2\n")
    heard = b""
    while heard.count(b"\n") < 2:
        heard += pair.port.read(100)
    assert pair.now_ms < 62_000


@pytest.mark.slow
def test_a_million_frames():
    pair = Pair(seed=7, share=0.01)
    pair.stream(MILLION)
    assert pair.frames >= MILLION and pair.wires[0].faults > 200_000
    assert percentile(pair.recoveries, 0.99) <= RECOVERY_MS


def test_a_clean_wire_is_used_well():
    """Compared with plain text: lines of a laser's picture, in check mode, in which the wire is the limit."""
    took = []
    for frames in (False, True):
        joined = MachineAndClient(frames=frames)
        for line in ("$X", "G21G91", "G1F3000", "$C"):
            joined.client.command(line)
        before = joined.machine.now_ms()
        lines = [(number, b"G1X0.%dY0.%dS%d" % (1 + number % 9, number * 7 % 10, 100 + number * 97 % 900)) for number in range(3000)]
        assert [number for number, _ in lines] == list(joined.client.stream(lines))
        took.append(joined.machine.now_ms() - before)
    plain, framed = took
    assert framed <= plain / 0.95, f"{framed} ms in frames, {plain} in plain text"


def path_of(machine):
    """Return the path, step by step, with the tool."""
    machine.settle()
    return [row[1:] for row in machine.trace.rows()]


def test_noise_moves_nothing_else():
    """The same path, step by step, over a clean wire in plain text and over a noisy one in frames."""
    lines = [(number, b"G1X%d.%dY%d.%d" % (number % 4, number * 7 % 10, number % 3, number * 3 % 10)) for number in range(150)]
    paths = []
    for frames, share in ((False, 0), (True, 0.01)):
        joined = MachineAndClient(21, share, frames)
        for line in ("$X", "G21G90", "F4000"):
            joined.client.command(line)
        assert [number for number, _ in lines] == list(joined.client.stream(lines))
        paths.append(path_of(joined.machine))
    assert len(paths[0]) > 5000 and paths[0] == paths[1]


def test_a_reset_drops_what_was_sent_before_it():
    """Lines that have not come move nothing after a reset, however late they would come; nothing else is lost."""
    joined = MachineAndClient(5, 0.02)
    client, port = joined.client, joined.client._serial
    for line in ("$X", "G21G90", "F6000"):
        client.command(line)
    for number in range(500):  # more bytes than half of the numbers
        port.write(b"G1X%d\n" % (number % 2 * 5))
    client.real_time(b"\x18")
    banners = client.banners
    joined.machine.run_ms(1)
    while client.banners == banners:
        client.read_lines()
    joined.machine.settle()
    there = list(joined.machine.plant.position)
    end = joined.machine.now_ms() + 3000
    while joined.machine.now_ms() < end:
        client.read_lines()
    assert joined.machine.plant.position == there
    client.command("$X")
    client.command("G1Y0.5F6000")
    joined.machine.settle()
    assert joined.machine.plant.position != there


def test_a_board_that_was_reset_is_noticed():
    """The link is plain again and the client says it; of its lines under way none moves the machine."""
    joined = MachineAndClient()
    client, port = joined.client, joined.client._serial
    client.command("$X")
    line = joined.machine.app.links[0].serial
    fresh = type(line)(joined.machine.app.links[0], line._serial, 115_200, line._clock, line._note)
    joined.machine.app.links[0].serial = fresh
    port.write(b"G1X5F600\n")
    with pytest.raises(OSError, match="reset"):
        for _ in range(2000):
            port.read(1)


def virtual_board(tmp_path):
    """(process, path of its pty) of a router whose first link has frames."""
    text = (ROOT / "boards" / "router_3axis.py").read_text()
    path = tmp_path / "framed_router.py"
    path.write_text(text.replace('"port": "usb", "protocol": "grbl"', '"port": "usb", "protocol": "grbl", "frames": True'))
    link = tmp_path / "port"
    process = subprocess.Popen(
        [*interpreter.passo(), "board", "--board", str(path), "--time", "fast", "--link", str(link), "--trace", str(tmp_path / "trace.csv")],
        stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stdout.readline().startswith("port:")
    return process, link


def last_place(tmp_path):
    x, y = (tmp_path / "trace.csv").read_text().splitlines()[-1].split(",")[1:3]
    return int(x), int(y)


@pytest.mark.unmeasured
@pytest.mark.skipif(not shutil.which("node"), reason="no node")
def test_a_client_written_from_the_page_moves_a_board(tmp_path):
    """In another language, without a line of Passo: lines, a reset that overtakes them, and a second session."""
    process, link = virtual_board(tmp_path)
    command = ["node", str(Path(__file__).parent / "frames_from_the_page.js"), str(link)]
    try:
        job = "$X\nG21G91\n" + "G1X0.5F6000\nG1Y0.5\n" * 60 + "G4P0\n"
        for text, answers in ((job, ["ok"] * 123), ("!?\nG1XY\n", ["error:2"]), ("^\x18\n$X\nG91G1X1F600\nG4P0\n", ["ok"] * 3)):
            said = subprocess.run(command, input=text, stdout=subprocess.PIPE, check=True, text=True, timeout=60).stdout
            assert re.findall(r"ok|error:\d+", said) == answers, said
            assert ("<Idle|MPos:30.000,30.000" in said) == ("?" in text)
    finally:
        process.terminate()
        process.wait(20)
    assert last_place(tmp_path) == (62 * 160, 60 * 160)


@pytest.mark.unmeasured
def test_the_reference_client_moves_a_board(tmp_path):
    process, link = virtual_board(tmp_path)
    try:
        job = tmp_path / "job.gcode"
        job.write_bytes(b"$X\nG21G91\nG1X1F6000\nG1Y2\nG4P0\nG1XY\n")
        for _ in range(2):
            said = subprocess.run([*interpreter.python(), str(REFERENCE), str(link), str(job)], stdout=subprocess.PIPE, check=True, text=True, timeout=60).stdout
            assert re.findall(r"ok|error:\d+", said) == ["ok"] * 5 + ["error:2"]
    finally:
        process.terminate()
        process.wait(20)
    assert last_place(tmp_path) == (640, 1280)
