"""A sender that speaks plain grbl by a WebSocket: beside the page of `passo panel`, and behind `passo wifi bridge`."""

import hmac
import re
import subprocess
import time
from concurrent.futures import ThreadPoolExecutor

import pytest
import websocket

from board_browser import LINKS
from host_tools import boards, interpreter
from host_tools.sim.websocket_line import WebSocketLine
from panel_process import LIMIT_S, PanelProcess
from test_board_command import Board

KEY = "ABCDEFGHJKLMNPQR"


class Sender:
    def __init__(self, address):
        self.address = address
        self.socket = websocket.create_connection(address, timeout=LIMIT_S, suppress_origin=True)
        self._heard = ""

    def until(self, wanted):
        """Read up to `wanted` and return the text before it."""
        while wanted not in self._heard:
            self._heard += self.socket.recv()
        said, _, self._heard = self._heard.partition(wanted)
        return said

    def say(self, line):
        self.socket.send(line + "\n")

    def report(self):
        self.socket.send("?")
        return "<" + self.until(">").rpartition("<")[2]

    def ask(self, line):
        self.say(line)
        while not (found := re.search(r"(ok|error:\d+)\r\n", self._heard)):
            self._heard += self.socket.recv()
        self._heard = self._heard[found.end() :]
        return found[1]


class SignedSender(Sender):
    """At the board's own server: each line proves the key, by Python's own hmac."""

    def __init__(self, address):
        super().__init__(address)
        self.until("[PASSO:")
        self._nonce = self.until("]")
        self._count = 0

    def say(self, line):
        self._count += 1
        said = f"{self._nonce}.{self._count}.{line}".encode()
        self.socket.send(f"{self._count}.{hmac.new(KEY.encode(), said, 'sha256').hexdigest()}.{line}\n")


def a_short_day(sender):
    """Asked, jogged, a job, and a reset amid a move; returns the place, mm."""

    def idle():
        while "<Idle" not in (said := sender.report()):
            pass
        return [float(mm) for mm in re.search(r"MPos:([-\d.,]+)", said)[1].split(",")]

    assert sender.ask("G91G0X1") == "error:112", "somebody else commands"
    assert sender.ask("$LINK=0") == "ok" and sender.ask("$X") == "ok"
    start = idle()
    assert sender.ask("$J=G91X2F3000") == "ok"
    assert idle() == [start[0] + 2, *start[1:]]
    for line in ("G21 G91", "G1 X3 F3000", "Y2", "G2 X-2 Y2 J2", "G4 P0.01"):
        assert sender.ask(line) == "ok", line
    assert idle() == [start[0] + 3, start[1] + 4, start[2]]
    assert sender.ask("G1 X60 F600") == "ok"
    while "<Run" not in sender.report():
        pass
    sender.socket.send("\x18")
    assert "ALARM:3" in sender.until("Grbl 1.1h") and "<Alarm" in sender.report()
    return start


def test_bytes_both_ways():
    line = WebSocketLine(0)
    try:
        with pytest.raises(websocket.WebSocketBadStatusException):
            _connect(line, origin="http://evil.example")
        client = _connect(line, suppress_origin=True)
        client.send("G0 X1\n")
        client.send_binary(b"?")
        come = b""
        while come != b"G0 X1\n?":
            come += line.read()
        line.write(b"ok\r\n" * 1000)
        heard = ""
        while len(heard) < 4000:
            line.read()
            heard += client.recv()
        assert heard == "ok\r\n" * 1000
        client.close()
    finally:
        line.close()


def test_who_loses_the_line_is_told():
    line = WebSocketLine(0)
    try:
        first = _connect(line, suppress_origin=True)
        second = _connect(line, suppress_origin=True)
        assert first.recv() == "[MSG:Another program has taken this connection]\r\n" and line.clients == 2
        second.send("?")
        come = b""
        while not come:
            come += line.read()
        assert come == b"?"
    finally:
        line.close()


def _connect(line, **options):
    """A client, made while the line is read."""
    with ThreadPoolExecutor(1) as pool:
        made = pool.submit(websocket.create_connection, line.name, timeout=LIMIT_S, **options)
        while not made.done():
            line.read()
            time.sleep(0.001)
        return made.result()


@pytest.mark.slow
@pytest.mark.unmeasured
def test_beside_the_page(tmp_path):
    with PanelProcess(tmp_path, "--guest", "ws:0") as panel:
        sender = Sender(panel.guest)
        page = panel.page().ready()
        assert sender.ask("$LINK=0") == "error:178" and page.said("asks")["name"] == panel.guest
        assert page.order("give", to="guest")["error"] == 0 and page.order("give", to="page")["error"] == 0
        start = a_short_day(sender)
        page.until(lambda state: state["owner"] == "guest" and start[0] + 3 < state["m"][0] < start[0] + 60)
        assert page.order("step", by={"x": 1}, speed=600)["error"] == 112


@pytest.mark.slow
@pytest.mark.unmeasured
def test_at_the_server_of_a_board(tmp_path):
    """At the port that serves its page, too; a second sender has to wait until the first has gone."""
    config = {**boards.load("router_3axis"), "network": {"host": "passo"}, "links": LINKS}
    path = tmp_path / "served.py"
    path.write_text(f'"""A router."""\n\nBOARD = {config!r}\n')
    with Board("--board", path, "--http", 0, "--signed", 0, "--key", KEY, links=4) as board:
        address = re.match(r"http: http://(\S+)/#key=", board.lines[1])[1]
        sender = SignedSender(f"ws://{address}/grbl")
        sender.socket.send("G0X1\n")
        assert sender.until("error:178") is not None, "a line that proves nothing"
        a_short_day(sender)
        with pytest.raises(websocket.WebSocketBadStatusException, match="503"):
            SignedSender(f"ws://{address}/grbl")
        sender.socket.close()
        deadline = time.monotonic() + LIMIT_S
        while True:
            try:
                assert SignedSender(f"ws://{address}/grbl").ask("$X") == "ok"
                break
            except websocket.WebSocketBadStatusException:
                assert time.monotonic() < deadline
                time.sleep(0.05)


@pytest.mark.slow
@pytest.mark.unmeasured
def test_behind_the_bridge(tmp_path):
    config = {**boards.load("router_3axis"), "network": {"host": "passo"}}
    config["links"] = [config["links"][0], LINKS[2]]
    path = tmp_path / "served.py"
    path.write_text(f'"""A router."""\n\nBOARD = {config!r}\n')
    with Board("--board", path, "--signed", 0, "--key", KEY, links=3) as board:
        port = board.lines[1].rsplit(":", 1)[1]
        words = [*interpreter.passo(), "wifi", "bridge", "127.0.0.1", "--tcp-port", port, "--key", KEY, "--websocket", "0"]
        bridge = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True)
        try:
            sender = Sender(re.match(r"port: (ws:\S+)", bridge.stdout.readline())[1])
            token = re.match(r"token: (\S+)", bridge.stdout.readline())[1]
            assert sender.ask("$LINK=0") == "error:178" and sender.ask(f"$TOKEN={token}") == "error:178", "it was not the first line"
            sender = Sender(sender.address)
            assert sender.ask(f"$TOKEN={token}") == "ok"
            assert sender.ask("$LINK=0") == "ok" and sender.ask("$X") == "ok" and sender.ask("G91G0X1") == "ok"
        finally:
            bridge.terminate()
            bridge.wait()
            bridge.stdout.close()
