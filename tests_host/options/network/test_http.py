"""The board's HTTP as `passo board --http` serves it: by curl and requests, by two clients at once, and under attack."""

import csv
import http.client
import json
import random
import re
import shutil
import socket
import subprocess
import threading
import time
from types import SimpleNamespace

import pytest
import requests

from host_tools import interpreter
from passo.protocols.torch import protocol as torch
from passo.web.files import Folder
from passo.web.http import Server
from passo.web.session import Hmac
from test_board_command import COMMAND, Board

KEY = "ABCDEFGHJKLMNPQR"
LIMIT_S = 60
BODY = "x=100&y=100&xv=100&yv=100"
MOVES = ("/COMMAND", "/CONFIG", "/ON", "/OFF", "/ORIGIN", "/JOGX+", "/JOGX-", "/JOGY+", "/JOGY-")


class Torch:
    """`passo board` with HTTP, and clients for it."""

    def __init__(self, board, *options):
        self.board = Board("--board", board, "--http", 0, "--key", KEY, *options, links=3)
        self.url = re.match(r"http: (http://\S+)/#key=", self.board.lines[1])[1]
        self.address = tuple(self.url[7:].split(":"))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.board.__exit__()

    def connect(self, source="127.0.0.1"):
        made = socket.create_connection((self.address[0], int(self.address[1])), LIMIT_S, (source, 0))
        made.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return made

    def raw(self, data, source="127.0.0.1"):
        """All that is answered to these bytes."""
        with self.connect(source) as wire:
            wire.sendall(data)
            answer = b""
            try:
                while data := wire.recv(65536):
                    answer += data
            except ConnectionResetError:
                pass
            return answer

    def info(self):
        return requests.get(self.url + "/INFO?json", timeout=LIMIT_S).json()

    def settled(self):
        """INFO once nothing moves."""
        deadline = time.monotonic() + LIMIT_S
        while time.monotonic() < deadline:
            found = self.info()
            if found["state"] != "running":
                return found
            time.sleep(0.02)
        raise AssertionError("it moves for ever")


class Keyed:
    """A client that proves the key; it learns nonce and count from the answers, and asks once more if another was quicker."""

    def __init__(self, url, key=KEY):
        self.url = url
        self.key = key
        self.nonce = None
        self.count = 0

    def _once(self, path, body):
        headers = {"Accept": "application/json"}
        if self.nonce:
            self.count += 1
            signed = f"{self.nonce}.{self.count}.POST {path} {body}"
            headers["X-Passo"] = f"{self.count}.{Hmac(self.key.encode()).hex_digest(signed.encode())}"
        answer = requests.post(self.url + path, data=body, headers=headers, timeout=LIMIT_S)
        if answer.status_code == 503:  # too many in this second: again
            time.sleep(0.1)
            return {"error": 178}
        self.nonce = answer.headers["X-Passo-Nonce"]
        self.count = max(self.count, int(answer.headers["X-Passo-Count"]))
        assert answer.status_code == 200
        return answer.json()

    def post(self, path, body="", tries=50):
        for _ in range(tries):
            found = self._once(path, body)
            if found["error"] != 178:
                break
        return found


def legacy_board(folder, **changes):
    """Write torch_pico_w with the forms of 2020, which a board file may allow."""
    from host_tools import boards

    data = {**boards.load("torch_pico_w"), **changes}
    data["network"] = {**data["network"], "legacy_http": True}
    path = folder / "legacy.py"
    path.write_text(f'"""The torch that admits the program of 2020."""\n\nBOARD = {data!r}\n')
    return path


def admit(wire, minutes):
    wire.write(torch.passo(torch.ADMIT_OF, minutes) + torch.passo(torch.STATUS_OF))
    cutter = torch.answer_cutter()
    while (found := cutter.next_frame()) is None:
        cutter.put_bytes(wire.read(1), 0)
    return torch.answer_from(found)[1]


def curl(url, *options):
    """(head lines, body) of an answer."""
    said = subprocess.run(["curl", "-s", "-i", *options, url], capture_output=True, timeout=LIMIT_S, check=True).stdout
    head, _, body = said.partition(b"\r\n\r\n")
    return head.decode().split("\r\n"), body


def test_a_stop_that_overtakes_an_order():
    """An order signed before a STOP that comes after it has an old proof; one that waits in the server is refused, not carried out after the STOP."""
    with Torch("torch_pico_w") as torch_board:
        client = Keyed(torch_board.url)
        assert client.post("/ON")["error"] == 0
        late, stop = Keyed(torch_board.url), Keyed(torch_board.url)
        late.nonce = stop.nonce = client.nonce
        late.count, stop.count = client.count, client.count + 1
        assert stop.post("/HALT")["error"] == 0
        assert late.post("/COMMAND", BODY, tries=1)["error"] == 178
        found = torch_board.settled()
        assert (found["px"], found["py"]) == (0, 0)
        assert stop.post("/COMMAND", BODY, tries=1)["error"] == 0
        assert torch_board.settled()["px"] == 100


class Proven:
    """A guard that takes everybody for proven, but for STOP."""

    def set_admission(self, *_):
        pass

    def refusal_status(self, connection, browser):
        return 0

    def headers(self):
        return b""

    def is_free(self, path):
        return path in (b"/HALT", b"/INFO")

    def is_proven(self, connection, now_ms):
        return True


def test_orders_that_wait_are_refused_by_a_stop(tmp_path):
    listener = socket.socket()
    listener.bind(("127.0.0.1", 0))
    listener.listen(9)
    server = Server(listener, Folder(str(tmp_path) + "/"), Proven(), lambda: 0, False)
    language = SimpleNamespace(POSTS=(b"/COMMAND", b"/HALT"), GETS=(b"/INFO",), FREE=(), KEYED=(), PAGE="torch.html")
    server.join(SimpleNamespace(protocol=language), None)
    wires = []
    for line in (b"POST /COMMAND", b"GET /INFO", b"POST /COMMAND", b"POST /HALT"):
        wires.append(socket.create_connection(listener.getsockname(), LIMIT_S))
        wires[-1].sendall(line + b" HTTP/1.1\r\nHost: a\r\nAccept: application/json\r\n\r\n")
        deadline = time.monotonic() + LIMIT_S
        while len(server._requests) < len(wires) and b"/HALT" not in line and time.monotonic() < deadline:
            server.poll(0)
    for _ in range(200):
        server.poll(0)
    assert [wire.recv(1000)[9:12] for wire in (wires[0], wires[2])] == [b"409"] * 2
    assert [server.read()[2:].split(b" ")[0] for _ in range(3)] == [b"/HALT", b"/INFO", b""]
    for wire in wires:
        wire.close()
    server.close()


@pytest.mark.skipif(not shutil.which("curl"), reason="no curl")
def test_the_program_of_2020(tmp_path):
    """The document's table by curl, without a key, as its program sends it: byte for byte what the document gives."""
    with Torch(legacy_board(tmp_path), "--time", "fast") as torch_board:
        url = torch_board.url
        form = ("-H", "Host: 192.168.4.1", "-H", "Content-Type: application/x-www-form-urlencoded")
        refused = {"code": 254, "state": "stopped", "error": 178}
        assert json.loads(curl(url + "/COMMAND?json", *form, "-d", BODY)[1]) == refused
        with torch_board.board.open() as cable:
            cable.timeout = LIMIT_S
            before = admit(cable, 5)
            assert before["dropped"] == 0
        steps = [
            ("/ON", "", "code=238&state=stopped&error=0"),
            ("/COMMAND", BODY, "code=254&state=running&error=0&x=100&xv=100&y=100&yv=100"),
            ("/INFO", None, "code=187&state=finished&error=0&x=100&y=100&px=100&py=100&"),
            ("/COMMAND", "x=40&y=30&xv=-480&yv=830", "code=254&state=running&error=0&x=40&xv=-480&y=30&yv=830"),
            ("/INFO", None, "code=187&state=finished&error=0&x=-40&y=30&px=60&py=130&"),
            ("/CONFIG", "jogx=100&jogy=100&xv=100&yv=100", "code=153&state=finished&error=0&jogx=100&jogy=100&xv=100&yv=100"),
            ("/JOGX+", "", "code=249&state=running&error=0"),
            ("/JOGX-", "", "code=247&state=running&error=0"),
            ("/JOGY+", "", "code=244&state=running&error=0"),
            ("/JOGY-", "", "code=241&state=running&error=0"),
            ("/HALT", "", "code=221&state=stopped&error=0&x=0&y=-100&px=60&py=130"),
            ("/ORIGIN", "", "code=136&state=stopped&error=0"),
            ("/INFO", None, "code=187&state=stopped&error=0&x=0&y=-100&px=0&py=0&"),
            ("/OFF", "", "code=204&state=stopped&error=0"),
        ]
        for path, body, wanted in steps:
            torch_board.settled()
            head, told = curl(url + path, *form, *(("-d", body) if body is not None else ()))
            assert head[0] == "HTTP/1.1 200 OK" and "Content-Type: text/html; charset=utf-8" in head, path
            found = re.search(rb'<pre id="answer">(.*?)</pre>', told)[1].decode()
            assert found.startswith(wanted) and (wanted.endswith("&") or found == wanted), path
            assert b"<form method=\"post\" action=\"/COMMAND\"" in told and told.rstrip().endswith(b"</script>")
        # Not from another network, not for another site, not without the word of somebody at the machine.
        assert json.loads(curl(url + "/ON?json", *form, "-d", "", "--interface", "127.0.1.1")[1])["error"] == 178
        assert curl(url + "/ON", *form, "-d", "", "-H", "Origin: http://evil.example")[0][0] == "HTTP/1.1 403 Forbidden"
        with torch_board.board.open() as cable:
            cable.timeout = LIMIT_S
            admit(cable, 0)
        assert json.loads(curl(url + "/ON?json", *form, "-d", "")[1])["error"] == 178
        assert torch_board.board.end()[0] == 0


def test_two_clients_at_once():
    """Two who have the key jog by turns as fast as they can, and one looks on: every jog that was accepted was made."""
    with Torch("torch_pico_w", "--time", "fast") as torch_board:
        first = Keyed(torch_board.url)
        assert first.post("/ON")["error"] == 0
        assert first.post("/CONFIG", "jogx=7&jogy=11&xv=4000&yv=4000")["error"] == 0
        made = {"x": 0, "y": 0}
        stop = threading.Event()

        def work(client, axis):
            for _ in range(25):
                if client.post(f"/JOG{axis.upper()}+")["error"] == 0:
                    made[axis] += 1
                torch_board.settled()

        def look():
            while not stop.is_set():
                torch_board.info()

        workers = [threading.Thread(target=work, args=(client, axis)) for client, axis in ((first, "x"), (Keyed(torch_board.url), "y"))]
        watcher = threading.Thread(target=look)
        for thread in [*workers, watcher]:
            thread.start()
        for thread in workers:
            thread.join()
        stop.set()
        watcher.join()
        found = torch_board.settled()
        assert made["x"] > 5 and made["y"] > 5
        assert found["px"] % 7 == 0 and found["py"] % 11 == 0
        assert 0 < found["px"] <= 7 * made["x"] and 0 < found["py"] <= 11 * made["y"]


def test_the_position_is_pushed():
    """Server-sent events while it moves, to two pages; the third gets 503: no room."""
    with Torch("torch_pico_w") as torch_board:
        keyed = Keyed(torch_board.url)
        pages = []
        for _ in range(2):
            page = http.client.HTTPConnection(*torch_board.address, timeout=LIMIT_S)
            page.request("GET", "/EVENTS")
            pages.append(page.getresponse())
            assert pages[-1].status == 200 and pages[-1].getheader("Content-Type") == "text/event-stream"
        assert requests.get(torch_board.url + "/EVENTS", timeout=LIMIT_S).status_code == 503
        assert keyed.post("/ON")["error"] == 0
        assert keyed.post("/COMMAND", "x=480&y=0&xv=480&yv=1")["error"] == 0
        for page in pages:
            places = []
            while not places or places[-1] < 480:
                line = page.readline()
                if line.startswith(b"data: "):
                    places.append(json.loads(line[6:])["px"])
            assert places == sorted(places) and len(set(places)) > 3


def test_the_page_and_its_files():
    with Torch("torch_pico_w", "--time", "fast") as torch_board:
        page = requests.get(torch_board.url + "/", timeout=LIMIT_S)
        assert page.status_code == 200 and "script-src 'self'" in page.headers["Content-Security-Policy"]
        for name in re.findall(r'(?:href|src)="(/[^"]+)"', page.text):
            found = requests.get(torch_board.url + name, timeout=LIMIT_S, stream=True)
            packed = found.raw.read()
            assert found.status_code == 200 and packed and len(packed) == int(found.headers["Content-Length"])
        for path in ("/panel.js", "/../wifi.json", "/%2e%2e/wifi.json", "//wifi.json", "/torch.js/..", "/torch.js%00", "/page/torch.js"):
            assert torch_board.raw(f"GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode()).startswith(b"HTTP/1.1 404 "), path


def requests_of_an_attacker(random_of, url):
    """One torn, foreign, forged or senseless request."""
    methods = ("GET", "POST", "PUT", "DELETE", "OPTIONS", "HEAD", "TRACE", "post", "")
    paths = (*MOVES, "/", "/INFO", "/EVENTS", "/../../etc/passwd", "/wifi.json", "/torch.js", "/JOGX%2B", "/COMMAND?x=1", "*")
    hosts = (url[7:], "192.168.4.1", "evil.example", "", "127.0.0.1.evil.example")
    bodies = (BODY, "", "x=1", "jogx=1&jogy=1&xv=1&yv=1", "x" * 300, "\x00\xff", "x=100&x=100&y=1&xv=1&yv=1")
    pick = random_of.choice
    body = pick(bodies)
    lines = [f"{pick(methods)} {pick(paths)} HTTP/1.1", f"Host: {pick(hosts)}"]
    lines += [f"Origin: {pick(('http://evil.example', 'null', 'http://' + hosts[0]))}"] * random_of.randrange(2)
    lines += [f"X-Passo: {pick(('', '1', '1.', '-1.0', '1.' + '0' * 64, '99999999999999.' + 'f' * 64, 'ff.é'))}"] * random_of.randrange(2)
    lines += [f"Content-Length: {pick((str(len(body)), '-1', '99999', '0', '1e9', ''))}"] * random_of.randrange(3)
    lines += ["Transfer-Encoding: chunked"] * (random_of.random() < 0.05)
    lines += ["X: " + "y" * random_of.choice((1, 100, 700))] * random_of.choice((0, 0, 1, 60))
    data = ("\r\n".join(lines) + "\r\n\r\n" + body).encode("latin-1")
    return data[: random_of.randrange(len(data))] if random_of.random() < 0.2 else data


def attack(torch_board, count, seed):
    """Send `count` requests without the key, whose answers may reveal nothing. Returns the answers' status lines."""
    random_of = random.Random(seed)
    statuses = set()
    held = []
    for _ in range(count):
        wire = torch_board.connect("127.0.1.1" if random_of.random() < 0.3 else "127.0.0.1")
        try:
            wire.sendall(requests_of_an_attacker(random_of, torch_board.url))
            if random_of.random() < 0.05:
                held.append(wire)  # a slow one: never ends
                continue
            wire.shutdown(socket.SHUT_WR)
            wire.settimeout(LIMIT_S)
            said = wire.recv(65536)
            statuses.add(said.split(b"\r\n")[0])
            assert b"root:" not in said and KEY.encode() not in said and b"Traceback" not in said
        except OSError:  # dropped: too much, or too late
            pass
        wire.close()
        if len(held) > 200:
            held.pop(0).close()
    for wire in held:
        wire.close()
    return statuses


def steps_of(path):
    with open(path, newline="") as file:
        return [[float(field) for field in row] for row in list(csv.reader(file))[1:]]


@pytest.mark.parametrize("count, steps", [(400, 60_000), pytest.param(10_000, 750_000, marks=pytest.mark.slow)])
def test_attack_while_it_moves(tmp_path, count, steps):
    """30 000 steps a second while requests without the key come, 200 connections that say nothing among them: the path is the one that
    was asked for, each step at its time, and none more."""
    trace = tmp_path / "trace.csv"
    board = legacy_board(tmp_path, speed={"unit": "steps_per_s", "default": 480, "min": 1, "max": 40_000}, axes=fast_axes())
    with Torch(board, "--trace", trace, "--start", "100,100") as torch_board:
        keyed = Keyed(torch_board.url)
        assert keyed.post("/ON")["error"] == 0
        assert keyed.post("/COMMAND", f"x={steps}&y=0&xv=30000&yv=1")["error"] == 0
        idle = [torch_board.connect() for _ in range(200)]
        statuses = attack(torch_board, count, 7)
        for wire in idle:
            wire.close()
        assert b"HTTP/1.1 403 Forbidden" in statuses and b"HTTP/1.1 404 Not Found" in statuses
        found = torch_board.settled()
        assert (found["px"], found["py"], found["x"], found["y"]) == (steps, 0, steps, 0)
        assert torch_board.board.end()[0] == 0
    rows = [row for row in steps_of(trace) if row[1] > 0]
    assert len(rows) == steps and {row[2] for row in rows} == {0.0}
    gaps = [after[0] - before[0] for before, after in zip(rows, rows[1:])]
    assert max(gaps) - min(gaps) < 0.2 and abs(sum(gaps) / len(gaps) - 1e6 / 30_000) < 0.001  # µs


def fast_axes():
    from host_tools import boards

    return [{**axis, "max_mm_min": 60_000, "travel_steps": 1_000_000} for axis in boards.load("torch_pico_w")["axes"]]


def test_stop_among_200_idle_connections():
    """HALT needs no key, and slow connections do not keep it out."""
    with Torch("torch_pico_w") as torch_board:
        keyed = Keyed(torch_board.url)
        assert keyed.post("/ON")["error"] == 0
        assert keyed.post("/COMMAND", "x=48000&y=0&xv=480&yv=1")["error"] == 0
        idle = [torch_board.connect() for _ in range(200)]
        for wire in idle:
            wire.sendall(b"POST /COMMAND HTTP/1.1\r\nHost: ")
        found = requests.post(torch_board.url + "/HALT?json", timeout=LIMIT_S).json()
        assert found["error"] == 0 and found["state"] == "stopped" and 0 <= found["px"] < 48_000
        assert torch_board.info()["px"] == found["px"]
        for wire in idle:
            wire.close()


def test_no_http_where_no_link_has_it():
    process = subprocess.run(
        [*COMMAND, "--http", "0"], capture_output=True, text=True, timeout=LIMIT_S, env=interpreter.environment()
    )
    assert process.returncode and "no link of the board file plotter_2014 has the port http" in process.stderr
