"""grbl over the board's network: nothing moves without the key, a sender behind `passo wifi bridge` works, a lost link ends a jog."""

import re
import socket
import time

import pytest

from host_tools import boards
from host_tools.clients.signed import Bridge
from host_tools.failure import Failure
from test_board_command import Board

KEY = "ABCDEFGHJKLMNPQR"
LIMIT_S = 60


class Memory:
    """The sender's end of a bridge."""

    def __init__(self):
        self.said = b""
        self.heard = b""

    def read(self):
        data, self.said = self.said, b""
        return data

    def write(self, data):
        self.heard += data

    def select_list(self):
        return []


class Sender:
    def __init__(self, port, key=KEY):
        self.line = Memory()
        self.bridge = Bridge("127.0.0.1", port, key, self.line)

    def say(self, data):
        self.line.said += data
        self.bridge.carry_bytes(0)

    def until(self, wanted):
        """Read up to `wanted` and return the text before it."""
        deadline = time.monotonic() + LIMIT_S
        while wanted not in self.line.heard:
            assert time.monotonic() < deadline, self.line.heard
            self.bridge.carry_bytes(10)
        head, _, self.line.heard = self.line.heard.partition(wanted)
        return head

    def ask(self, line):
        """ok, or the error of a line."""
        self.say(line + b"\n")
        deadline = time.monotonic() + LIMIT_S
        while not (found := re.search(rb"(ok|error:\d+)\r\n", self.line.heard)):
            assert time.monotonic() < deadline, self.line.heard
            self.bridge.carry_bytes(10)
        self.line.heard = self.line.heard[found.end() :]
        return found[1]

    def report(self):
        self.line.heard = b""
        self.say(b"?")
        return self.until(b">").decode()

    def place(self):
        return float(re.search(r"MPos:([-\d.]+)", self.report())[1])


@pytest.fixture
def port(tmp_path):
    """The TCP port of a router's network."""
    board = boards.load("router_3axis")
    board["network"] = {"presence": "hand"}
    board["inputs"] = [*board["inputs"], {"name": "hand", "pin": 28}]
    board["links"] = [board["links"][0], {"name": "wifi", "port": "tcp", "protocol": "grbl"}]
    path = tmp_path / "networked.py"
    path.write_text(f'"""A router with a network."""\n\nBOARD = {board!r}\n')
    with Board("--board", path, "--signed", 0, "--key", KEY, "--start", "4000,4000,4000", links=3) as board:
        yield int(re.match(r"tcp: tcp://127.0.0.1:(\d+)", board.lines[1])[1])
        assert board.end()[0] == 0


def test_a_sender(port):
    sender = Sender(port)
    assert "MPos:0.000" in sender.report()
    assert sender.ask(b"$J=G91 X1 F600") in (b"error:112", b"error:9")
    assert sender.ask(b"$LINK=0") == b"ok" and sender.ask(b"$X") == b"ok"
    for line in (b"G21 G91", b"G1 X2 F3000", b"G1 X-1 F3000", b"G4 P0.01"):
        assert sender.ask(line) == b"ok", line
    assert sender.place() == 1.0
    # The tool goes on only while somebody holds the button at the machine; off it goes always.
    assert sender.ask(b"M3 S1000") == b"error:179" and sender.ask(b"M5") == b"ok"
    sender.say(b"\x90\x91")  # proven real-time bytes: feed override 100 %, then 110 %
    deadline = time.monotonic() + LIMIT_S
    while "Ov:110" not in sender.report():
        assert time.monotonic() < deadline
    # The second sender is refused; when the first has gone, its jog ends.
    with pytest.raises(Failure):
        Sender(port)
    assert sender.ask(b"$J=G91 X40 F600") == b"ok"
    while sender.place() <= 1.5:
        pass
    sender.bridge.close()
    deadline = time.monotonic() + LIMIT_S
    while True:
        try:
            again = Sender(port)
            break
        except Failure:
            assert time.monotonic() < deadline
            time.sleep(0.05)
    while "Idle" not in again.report():
        assert time.monotonic() < deadline
    assert again.place() < 20
    again.bridge.close()


def raw(port, data, wanted=rb"error:178"):
    """Return the answer to these bytes, and the nonce."""
    with socket.create_connection(("127.0.0.1", port), LIMIT_S) as wire:
        heard = b""
        while b"]\r\n" not in heard:
            more = wire.recv(4096)
            assert more, "hung up"
            heard += more
        nonce = re.search(rb"PASSO:(\w+)", heard)[1]
        wire.sendall(data)
        heard = b""
        while not re.search(wanted, heard):
            more = wire.recv(4096)
            if not more:
                break
            heard += more
        return heard, nonce


def test_without_the_key_nothing_moves(port):
    sender = Sender(port)
    assert sender.ask(b"$LINK=0") == b"ok" and sender.ask(b"$X") == b"ok" and sender.ask(b"G91") == b"ok"
    spoken = sender.bridge._prove_line(b"G1 X5 F600")  # heard on the wire, and not yet used
    place = sender.place()
    sender.bridge.close()
    time.sleep(0.2)
    for data in (b"G1 X5 F600\n", b"1." + b"0" * 64 + b".G1 X5 F600\n", spoken, b"\x90G1 X5\n", b"x" * 2000 + b"\n", b"~\xff\n"):
        assert b"error:178" in raw(port, data)[0], data
    with pytest.raises(Failure):  # a wrong key, until the board hangs up
        wrong = Sender(port, "ABCDEFGHJKLMNPQS")
        for _ in range(20):
            assert wrong.ask(b"G1 X5 F600") == b"error:178"
    report, first = raw(port, b"?", rb">\r\n")
    assert b"Idle" in report and f"MPos:{place:.3f}".encode() in report
    assert raw(port, b"?", rb">\r\n")[1] != first
