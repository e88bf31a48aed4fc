"""A sender that speaks plain grbl by a WebSocket: beside the page of `passo panel`, and behind `passo wifi bridge`."""

import re
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import pytest
import websocket

from board_browser import LINKS
from host_tools import boards
from host_tools.sim.websocket_line import WebSocketLine
from panel_process import LIMIT_S, PanelProcess
from test_board_command import Board

KEY = "ABCDEFGHJKLMNPQR"


class Sender:
    def __init__(self, address):
        self.socket = websocket.create_connection(address, timeout=LIMIT_S, suppress_origin=True)
        self._heard = ""

    def until(self, wanted):
        """What was said up to `wanted`."""
        while wanted not in self._heard:
            self._heard += self.socket.recv()
        said, _, self._heard = self._heard.partition(wanted)
        return said

    def ask(self, line):
        self.socket.send(line + "\n")
        while not (found := re.search(r"(ok|error:\d+)\r\n", self._heard)):
            self._heard += self.socket.recv()
        self._heard = self._heard[found.end() :]
        return found[1]


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
        sender.socket.send("?")
        assert sender.until(">")
        assert sender.ask("G91G0X1") == "error:112"
        assert sender.ask("$LINK=0") == "ok"
        assert sender.ask("G91G0X1") == "ok"
        page.until(lambda state: state["owner"] == "guest" and state["m"][0] == 1.0)


@pytest.mark.slow
@pytest.mark.unmeasured
def test_behind_the_bridge(tmp_path):
    config = {**boards.load("router_3axis"), "network": {"host": "passo"}}
    config["links"] = [config["links"][0], LINKS[2]]
    path = tmp_path / "served.py"
    path.write_text(f'"""A router."""\n\nBOARD = {config!r}\n')
    with Board("--board", path, "--signed", 0, "--key", KEY, links=3) as board:
        port = board.lines[1].rsplit(":", 1)[1]
        words = [sys.executable, "-m", "host_tools.cli", "wifi", "bridge", "127.0.0.1", "--tcp-port", port, "--key", KEY, "--websocket", "0"]
        bridge = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
        try:
            sender = Sender(re.match(r"port: (ws:\S+)", bridge.stdout.readline())[1])
            assert sender.ask("$LINK=0") == "ok" and sender.ask("$X") == "ok" and sender.ask("G91G0X1") == "ok"
        finally:
            bridge.terminate()
            bridge.wait()
            bridge.stdout.close()
