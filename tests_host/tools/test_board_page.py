"""The page that a board serves itself, under the same attacks as that of `passo panel`, while a cable streams to it."""

import csv
import re
import socket

import pytest

from host_tools import boards
from host_tools.clients.grbl import GrblClient
from panel_process import TICK_US, PageClient
from test_board_command import Board
from test_panel_network import FASTER, FASTEST_TICKS, JOB, ask, paces, paths, random_requests, refused_sockets, replays, request
from test_panel_network import too_much, without_a_key, wrong_hosts, wrong_keys

pytestmark = [pytest.mark.unmeasured, pytest.mark.slow, pytest.mark.xdist_group("panel")]
KEY = "ABCDEFGHJKLMNPQR"


class Served:
    """`passo board` with a page, and what the attacks want to know of it."""

    def __init__(self, folder):
        config = {**boards.load("router_3axis"), "network": {"host": "passo"}}
        config["links"] = [config["links"][0], {"name": "page", "port": "page", "protocol": "grbl"}]
        path = folder / "served.py"
        path.write_text(f'"""A router with a page."""\n\nBOARD = {config!r}\n')
        self.trace_file = folder / "trace.csv"
        self.board = Board("--board", path, "--http", 0, "--key", KEY, "--trace", self.trace_file, links=3)
        self.host = re.match(r"http: http://(\S+)/#key=", self.board.lines[1])[1]
        self.port = int(self.host.split(":")[1])
        self.key = KEY
        self.client = GrblClient(self.board.port, timeout_s=60)
        self.client.connect()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.client.__exit__()
        self.board.__exit__()

    def page(self, key=KEY):
        return PageClient(self.host, key)

    def run(self, work):
        """Stream JOB, and do a piece of `work` behind each line that is answered, until both have ended."""
        for line in ("$X", *FASTER, *JOB.splitlines()[:2]):
            self.client.command(line)
        pieces = iter(work)
        lines = [(number, line.encode()) for number, line in enumerate(JOB.splitlines()[2:])]
        for _ in self.client.stream(lines):
            next(pieces, None)
        for _ in pieces:
            pass
        self.client.wait_idle()

    def trace(self):
        with open(self.trace_file, newline="") as file:
            return [(round(float(row["t_us"]) / TICK_US), int(row["x"]), int(row["y"]), int(row["z"])) for row in csv.DictReader(file)]


def attacks(served, count):
    slow = [socket.create_connection(("127.0.0.1", served.port)) for _ in range(200)]
    for each in slow[:12]:
        each.send(b"GET / HT")
    yield
    for each in slow:
        each.close()
    for attack in (refused_sockets, wrong_hosts, wrong_keys, replays, without_a_key, paths, too_much):
        attack(served)
        yield
    while count > 0:
        random_requests(served, min(count, 50))
        count -= 50
        yield


def made(folder, count):
    folder.mkdir()
    with Served(folder) as served:
        served.run(attacks(served, count) if count else ())
        log = served.client.command("$LOG")
        assert served.board.end()[0] == 0
    return paces(served.trace()), log


@pytest.mark.parametrize("count", [300])
def test_under_attack(tmp_path, count):
    rows, _ = made(tmp_path / "attacked", count)
    assert rows == made(tmp_path / "alone", 0)[0], "another path, or a step at another time"
    assert len(rows) > 100_000 and FASTEST_TICKS in [row[0] for row in rows]


def test_stop_needs_no_key(tmp_path):
    with Served(tmp_path) as served:
        served.client.command("$X")
        served.client.command("G1 X60 F3000")
        assert b" 200" in ask(served, request(served, b"POST /stop HTTP/1.1"))
        page = served.page()
        page.until(lambda state: state["state"] == "Alarm")
        assert 0 <= page.state["m"][0] < 60
