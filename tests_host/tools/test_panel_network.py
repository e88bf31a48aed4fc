"""Bytes from a network: without the key nothing moves, no secret leaks, and no step is late, whatever the bytes."""

import itertools
import json
import random
import socket
import string
import time

import pytest
import websocket

from panel_process import LIMIT_S, PageClient, PanelProcess
from passo import errors

pytestmark = [pytest.mark.unmeasured, pytest.mark.xdist_group("panel")]

# Seven seconds at 95 mm/s and 30 400 steps a second, there and back.
FASTER = ("$110=6000", "$111=6000")
JOB = "G21 G91\nF5700\n" + "G1 X60\nG1 X-60\n" * 4 + "G1 X30 Y30\nG1 X-30 Y-30\n"
FASTEST_TICKS = 411  # 30 400 a second


def ask(panel, data, wait_s=LIMIT_S):
    """Return the server's answer to raw bytes, until it closes the connection."""
    with socket.create_connection(("127.0.0.1", panel.port), timeout=wait_s) as connection:
        try:
            connection.sendall(data)
            said = b""
            while piece := connection.recv(65_536):
                said += piece
            return said
        except (ConnectionError, TimeoutError):
            return b""


def request(panel, line=b"GET / HTTP/1.1", host=None, more=b""):
    return line + b"\r\nHost: " + (host or panel.host).encode() + b"\r\n" + more + b"\r\n"


def refused_sockets(panel):
    for origin in ("http://evil.example", "null", f"https://{panel.host}", f"http://{panel.host}.evil.example", "http://localhost:1"):
        with pytest.raises(websocket.WebSocketBadStatusException):
            PageClient(panel.host, panel.key, origin)
    upgrade = b"Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
    assert b" 403" in ask(panel, request(panel, b"GET /ws HTTP/1.1", more=upgrade)), "a WebSocket without an Origin"


def wrong_hosts(panel):
    for host in ("evil.example", f"evil.example:{panel.port}", "127.0.0.1.evil.example", ""):
        assert b" 403" in ask(panel, request(panel, host=host or " ")), host


def wrong_keys(panel):
    stranger = panel.page("A" * 16)
    for number in range(4):
        stranger.socket.send(stranger.message({"do": "step", "by": {"x": 5}, "speed": 5000}))
        assert stranger._find(lambda told: told["t"] == "answer")["error"] == errors.NO_SESSION, number
    stranger.socket.send(stranger.message({"do": "step"}))
    with pytest.raises((websocket.WebSocketConnectionClosedException, ConnectionError)):
        for _ in range(1000):
            stranger.hear()


def replays(panel):
    """A message of one page is worth nothing on another connection, nor a second time."""
    honest = panel.page()
    message = honest.message({"do": "step", "by": {"x": 5}, "speed": 5000})
    for _ in range(2):
        other = panel.page()
        other.socket.send(message)
        assert other._find(lambda told: told["t"] == "answer")["error"] == errors.NO_SESSION
    message = honest.message({"do": "jobs"})
    honest.socket.send(message)
    honest._find(lambda told: told["t"] == "jobs")
    honest.socket.send(message)
    assert honest._find(lambda told: told["t"] == "answer")["error"] == errors.NO_SESSION


def without_a_key(panel):
    page = panel.page()
    for name in ("step", "goto", "jog", "run", "output", "line", "resume", "give", "jobs", "job_text", "job_about", "machine", "teach", "stored", "recover"):
        page.socket.send(json.dumps({"do": name, "by": {"x": 5}, "to": {"x": 5}, "way": {"x": 1}, "speed": 5000, "line": "G0X9", "name": "job"}))
        answer = page._find(lambda told: told["t"] == "answer")
        known = name not in getattr(panel, "lacking", ())
        assert answer == {"t": "answer", "do": name if known else "", "error": errors.NO_SESSION if known else errors.UNKNOWN_COMMAND}


def too_much(panel):
    for size in (9_000, 200_000):
        ask(panel, request(panel, more=b"X: " + b"a" * size + b"\r\n"))
        ask(panel, b"G" * size)
        ask(panel, request(panel, b"POST /stop2 HTTP/1.1", more=b"Content-Length: %d\r\n" % size) + b"a" * size)
    for wrong in (b"\x00" * 100, b"GET\r\n\r\n", b"GET / HTTP/1.1\r\nno colon\r\n\r\n", b"POST /ws HTTP/1.1\r\nContent-Length: x\r\n\r\n", b"\r\n"):
        ask(panel, wrong)
    page = panel.page()
    try:
        page.socket.send("1." + "0" * 64 + "." + "a" * 200_000)
        while True:
            page.hear()
    except (websocket.WebSocketException, ConnectionError):
        pass
    flood = panel.page()
    try:
        for _ in range(2000):
            flood.socket.send('{"do":"home"}')
        while True:
            flood.hear()
    except (websocket.WebSocketException, OSError):  # closed amid a send: its descriptor may be gone
        pass


def paths(panel):
    for path in ("/../panel.py", "/..%2f..%2fserver.py", "/%2e%2e/server.py", "//etc/passwd", "/server.py", "/.", "/index.html/", "/pt.json%00", "/C:%5c"):
        said = ask(panel, request(panel, f"GET {path} HTTP/1.1".encode()))
        assert b" 200" not in said.split(b"\r\n")[0], path
    page = panel.page()
    for name in ("../x", "..", "/etc/passwd", "a/b", "a\\b", ".hidden", "", "con.txt", "x" * 61, "a\0b", "é"):
        for order, fields in (("job_part", {"at": 0, "text": "G0X1", "last": True}), ("job_text", {"at": 0}), ("job_remove", {}), ("run", {})):
            assert page.order(order, name=name, **fields)["error"], (order, name)


def random_requests(panel, count):
    """Requests of random methods, paths, heads and bodies; no answer has the key."""
    dice = random.Random(19)
    letters = string.printable.encode()
    for _ in range(count):
        method = dice.choice([b"GET", b"POST", b"PUT", b"DELETE", b"OPTIONS", b"HEAD", bytes(dice.choices(letters, k=5))])
        path = dice.choice([b"/", b"/ws", b"/stop1", b"/errors.json", b"/" + bytes(dice.choices(letters, k=dice.randrange(60)))])
        body = bytes(dice.choices(range(256), k=dice.randrange(300)))
        head = method + b" " + path + b" HTTP/1.1\r\nHost: " + dice.choice([panel.host.encode(), b"x", b""]) + b"\r\n"
        if dice.random() < 0.5:
            head += b"Content-Length: %d\r\n" % dice.choice([0, len(body), len(body) + 5, 10**12, -1])
        data = head + b"\r\n" + body
        with socket.create_connection(("127.0.0.1", panel.port), timeout=LIMIT_S) as connection:
            try:
                connection.sendall(data[: dice.randrange(len(data))] if dice.random() < 0.2 else data)
                connection.shutdown(socket.SHUT_WR)
                assert panel.key.encode() not in connection.recv(65_536)
            except OSError:
                pass


def fast(panel):
    """A page of a machine that is fast enough, with the job."""
    page = panel.page().ready()
    for line in FASTER:
        assert page.order("line", line=line)["error"] == 0
    page.put("job", JOB)
    return page


def attacked(folder, count):
    with PanelProcess(folder) as panel:
        page = fast(panel)
        slow = [socket.create_connection(("127.0.0.1", panel.port)) for _ in range(200)]  # of which most are closed at once
        for each in slow[:12]:
            each.send(b"GET / HT")
        assert page.order("run", name="job")["error"] == 0
        for each in slow:
            each.close()
        refused_sockets(panel)
        wrong_hosts(panel)
        wrong_keys(panel)
        replays(panel)
        without_a_key(panel)
        paths(panel)
        too_much(panel)
        random_requests(panel, count)
        page.socket.close()
        page = panel.page()
        state = page.until(lambda state: state["job"]["how"] in ("done", "failed") and state["state"] == "Idle")
        assert state["job"]["how"] == "done" and state["alarm"] == 0
        error = errors.BUSY
        while error in (errors.BUSY, errors.TOO_MANY_WAITING):  # the last line of the job is being answered
            error = page.order("line", line="$LOG")["error"]
        assert error == 0
        log = ""
        while "LOGGED" not in log:
            assert log[:6] != "error:", (log, page.told)  # an "ok" may still be that of the job's last line
            log = page.said("said")["text"]
        assert f"x{errors.WORDS_LATE}" not in log, log
    return panel.trace()


def alone(folder):
    with PanelProcess(folder) as panel:
        assert fast(panel).run("job")["how"] == "done"
    return panel.trace()


def paces(rows):
    """(ticks since the step before, place) of each step; no ticks where the machine stands: at the start, and where it turns round."""
    found, before = [], None
    for (then, *old), (now, *new) in itertools.pairwise(rows):
        way = [b - a for a, b in zip(old, new)]
        found.append((now - then if way == before else 0, *new))
        before = way
    return found


def compare(folder, count):
    (folder / "attacked").mkdir()
    (folder / "alone").mkdir()
    rows = paces(attacked(folder / "attacked", count))
    assert rows == paces(alone(folder / "alone")), "another path, or a step at another time"
    assert len(rows) > 100_000 and FASTEST_TICKS in [row[0] for row in rows]


def test_under_attack(tmp_path):
    compare(tmp_path, 300)


@pytest.mark.slow
def test_ten_thousand_random_requests(tmp_path):
    compare(tmp_path, 10_000)


def test_stop_needs_no_key(tmp_path):
    with PanelProcess(tmp_path) as panel:
        page = panel.page().ready()
        page.put("job", JOB)
        assert page.order("run", name="job")["error"] == 0
        page.until(lambda state: state["state"] == "Run" and state["line"])
        assert b" 200" in ask(panel, request(panel, b"POST /stop HTTP/1.1"))
        state = page.until(lambda state: state["job"]["how"] == "failed")
        assert state["job"]["error"] == errors.STOPPED
        assert 3 <= state["job"]["line"] < state["job"]["done"], "the line that it stopped in, not the last that was sent"
        page.until(lambda state: state["state"] == "Alarm")
    assert len(panel.trace()) < 100_000


def test_a_stop_that_overtakes_an_order(tmp_path):
    """An order that was sent before a STOP and comes after it is refused."""
    with PanelProcess(tmp_path) as panel:
        page = panel.page().ready()
        late = page.message({"do": "step", "by": {"x": 5}, "speed": 5000})
        said = f"{page.hello['nonce']}.{page.count}".encode()
        assert b" 200" in ask(panel, request(panel, b"POST /stop HTTP/1.1", more=b"Content-Length: %d\r\n" % len(said)) + said)
        page.socket.send(late)
        assert page._find(lambda told: told["t"] == "answer")["error"] == errors.STOPPED
        page.until(lambda state: state["state"] == "Idle")
        assert page.order("step", by={"x": 1}, speed=5000)["error"] == 0
        page.until(lambda state: state["state"] == "Idle" and state["m"][0] >= 1)
        assert page.state["m"][0] == 1, "the late one did not move it"


def test_nobody_is_kept_from_stop(tmp_path):
    """Slow heads, connections that say nothing, readers that take no answer, pages that prove nothing: they make room."""
    with PanelProcess(tmp_path) as panel:
        stop = request(panel, b"POST /stop HTTP/1.1")
        honest = panel.page().ready()

        def connections(count, data):
            opened = [socket.create_connection(("127.0.0.1", panel.port)) for _ in range(count)]
            for each in opened:
                try:
                    each.sendall(data)
                except OSError:
                    pass  # it has been closed for another
            return opened

        for count, data, stops in ((30, b"GET / HTTP/1.1\r\nHost: ", 40), (200, b"", 5), (60, request(panel, b"GET /panel.js HTTP/1.1"), 5)):
            taken = connections(count, data)
            for _ in range(stops):
                assert b" 200" in ask(panel, stop), (count, data)
            for each in taken:
                each.close()
        strangers = [PageClient(panel.host, "A" * 16) for _ in range(7)]
        assert honest.order("unlock")["error"] == 0
        more = panel.page()
        assert more.order("jobs")["t"] == "jobs", "in the place of a stranger"
        assert b" 200" in ask(panel, stop)
        assert honest.order("jobs")["t"] == "jobs", "a page with the key must stay connected"
        for _ in range(12):
            strangers.append(PageClient(panel.host, "A" * 16))
        assert honest.order("jobs")["t"] == "jobs" and more.order("jobs")["t"] == "jobs"
        for each in strangers:
            each.socket.close()


@pytest.mark.slow
def test_a_page_that_has_gone_is_given_up(tmp_path):
    """One whose computer went to sleep says nothing; its place is free after some seconds. One that answers pings stays."""
    with PanelProcess(tmp_path) as panel:
        silent = [panel.page(reads=False) for _ in range(7)]
        for each in silent:
            assert each.order("jobs")["t"] == "jobs"
        honest = panel.page()
        assert honest.order("jobs")["t"] == "jobs"
        with pytest.raises(websocket.WebSocketBadStatusException):
            panel.page()
        end = time.monotonic() + 12
        while time.monotonic() < end:
            honest.hear()
        assert panel.page().order("jobs")["t"] == "jobs" and honest.order("jobs")["t"] == "jobs"


@pytest.mark.slow
def test_a_panel_that_stood_still_gives_no_page_up(tmp_path):
    """Its computer was asleep or busy, and the pages have not been asked for a sign of life meanwhile."""
    with PanelProcess(tmp_path) as panel:
        page = panel.page()
        assert page.order("jobs")["t"] == "jobs"
        panel.stand_still(9)
        time.sleep(1)
        assert page.order("jobs")["t"] == "jobs"
