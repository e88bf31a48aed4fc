"""A TCP port that takes orders and a browser: it carries out no order that a page has the browser send."""

import socket
import time

import pytest
from hypothesis import given, strategies

from host_tools.sim.gate import WAIT_S, Gate
from host_tools.sim.serial_line import TcpLine
from running_router import Running

BODY = b"$LINK=0\n$X\n$J=G91X10F1000\nG91G1X5F600\n"
HEAD = b"Host: 127.0.0.1:5000\r\nOrigin: http://evil.example\r\nContent-Type: text/plain\r\nContent-Length: %d\r\n\r\n" % len(BODY)
STUN = bytes.fromhex("000300082112a442") + b"~\x18!~\n$X\n~\x91\x91" + bytes.fromhex("0019000411000000")  # of TURN; the bytes that look like orders are its number
REQUESTS = [method + b" / HTTP/1.1\r\n" + HEAD + BODY for method in (b"POST", b"GET", b"PUT", b"OPTIONS", b"PROPFIND")]


def board(data, gate):
    """The answers of a grbl that knows the lines of BODY only, and whatever it was given of `data`, all that come at once."""
    given, now = b"", 0.0
    rest = data
    for _ in range(len(data) + 200):
        got = gate.filter_bytes(rest, now)
        rest = b""
        if got is None:
            return given, True
        given += got
        for line in got.splitlines(True):
            if line.strip() and line[-1:] in b"\r\n":
                gate.note_answer(b"ok\r\n" if line.strip() in BODY.splitlines() else b"error:1\r\n")
        now += WAIT_S
    return given, False


@pytest.mark.parametrize("request_", REQUESTS + [b"GET /" + b"~" * 20_000 + b" HTTP/1.1\r\n" + HEAD, b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + BODY])
@pytest.mark.parametrize("piece", [1, 3, 5000])
def test_requests_and_tls(request_, piece):
    gate = Gate()
    given = b""
    for at in range(0, len(request_), piece):
        got = gate.filter_bytes(request_[at : at + piece], at)
        if got is None:
            break
        given += got
    assert got is None and given == b""


@pytest.mark.parametrize("length", [b"", b"\x00\x1c"])
def test_webrtc(length):
    assert Gate().filter_bytes(length + STUN, 0) is None


@given(strategies.lists(strategies.text("abcxyz:/ ()", min_size=1, max_size=30), min_size=5, max_size=9))
def test_at_the_fifth_refusal_nothing_more_is_read(lines):
    head = b"x:" + b"\r\nx:".join(line.encode() for line in lines) + b"\r\n"
    given, hung_up = board(head + BODY, Gate())
    assert hung_up and b"$" not in given


@pytest.mark.parametrize(
    "data",
    [
        b"\r\n\r\n\x18?$I\n$$\n$G\nG91G1X5F600\n", b"?", b"$X\nG1X1\n" * 9, b"\x18", b"G1X1\n", b"G X1\n", b"M3 S100\n", b"\n\n", b"F100\n",
        bytes(range(97, 123)), b"m\x01n\x00\xcaH", b"\x16\x10\n",
    ],
)
def test_what_senders_send_passes(data):
    gate = Gate()
    given, now = b"", 0.0
    rest = data
    for _ in range(100):
        got = gate.filter_bytes(rest, now)
        rest = b""
        assert got is not None
        given += got
        gate.note_answer(b"ok\r\n" * got.count(b"\n"))
        now += WAIT_S
    assert given == data


def test_a_garbled_line_behind_an_accepted_one_hangs_up_on_nobody():
    gate = Gate()
    assert gate.filter_bytes(b"$G\n", 0) == b"$G\n"
    gate.note_answer(b"[GC:G0]\r\nok\r\n")
    for _ in range(9):
        assert gate.filter_bytes(b"foo\n", 0) == b"foo\n"
        gate.note_answer(b"error:1\r\n")
    assert gate.filter_bytes(b"G1X1\n", 0) == b"G1X1\n"


@pytest.mark.parametrize("request_", REQUESTS[:1] + [b"x\n" * 7 + BODY])
def test_a_machine_does_not_move(request_):
    """And a sender that comes then is served."""
    with Running(line=TcpLine(0)) as running:
        address = ("127.0.0.1", int(running.line.name.rsplit(":", 1)[1]))
        with socket.create_connection(address, 10) as client:
            client.settimeout(10)
            client.sendall(request_)
            try:
                while client.recv(4096):
                    pass
            except ConnectionResetError:
                pass
        place = list(running.world.place)
        with socket.create_connection(address, 10) as client:
            client.settimeout(10)
            client.sendall(b"\x18")
            said = b""
            while b"Grbl" not in said:
                said += client.recv(4096)
            client.sendall(b"$G\n")
            while b"ok" not in said:
                said += client.recv(4096)
        assert running.app.controller.state == "alarm" and running.world.place == place, "not unlocked, not moved"
        time.sleep(0.05)
        assert running.world.place == place
