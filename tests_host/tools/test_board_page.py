"""The page that a board serves itself, under the same attacks as that of `passo panel`, while a cable streams to it."""

import csv
import os
import re
import socket

import pytest

from host_tools import boards
from host_tools.clients.grbl import GrblClient
from panel_process import TICK_US, PageClient
from test_board_command import Board
from test_panel_page import CHROMIUM, DRIVER, Browser
from test_panel_network import FASTER, FASTEST_TICKS, JOB, ask, paces, paths, random_requests, refused_sockets, replays, request
from test_panel_network import too_much, without_a_key, wrong_hosts, wrong_keys

pytestmark = [pytest.mark.unmeasured, pytest.mark.slow, pytest.mark.xdist_group("panel")]
KEY = "ABCDEFGHJKLMNPQR"


class Served:
    """`passo board` with a page, and the members that the attacks read."""

    lacking = ("run", "job_text", "job_about", "machine", "teach", "recover")  # orders of `passo panel` only

    def __init__(self, folder, name="router_3axis", **more):
        config = {**boards.load(name), "network": {"host": "passo"}, **more}
        cable = {key: value for key, value in config["links"][0].items() if key != "lost"}  # while it attacks, the host is silent for seconds
        config["links"] = [cable, {"name": "page", "port": "page", "protocol": cable["protocol"]}]
        path = folder / "served.py"
        path.write_text(f'"""A router with a page."""\n\nBOARD = {config!r}\n')
        self.trace_file = folder / "trace.csv"
        self.board = Board("--board", path, "--http", 0, "--key", KEY, "--trace", self.trace_file, links=3)
        self.host = re.match(r"http: http://(\S+)/#key=", self.board.lines[1])[1]
        self.port = int(self.host.split(":")[1])
        self.address = f"http://{self.host}/"
        self.key = KEY
        self.client = None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.client:
            self.client.__exit__()
        self.board.__exit__()

    def cable(self):
        """A client of grbl on the board's cable."""
        self.client = GrblClient(self.board.port, timeout_s=60)
        self.client.connect()
        return self.client

    def page(self, key=KEY):
        return PageClient(self.host, key)

    def run(self, work):
        """Stream JOB, and do a piece of `work` behind each line that is answered, until both have ended."""
        self.cable()
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
    with Served(folder, jobs={"language": "grbl"}) as served:
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
        cable = served.cable()
        cable.command("$X")
        cable.command("G1 X60 F3000")
        assert b" 200" in ask(served, request(served, b"POST /stop HTTP/1.1"))
        page = served.page()
        page.until(lambda state: state["state"] == "Alarm")
        assert 0 <= page.state["m"][0] < 60


@pytest.mark.parametrize("name", ["router_3axis", "router_4axis", "torch_manipulator", "plotter_2014", "lpt_router", "two_motor_kit"])
def test_each_language(tmp_path, name):
    """Each machine has the same page: it takes control, and its orders are carried out."""
    with Served(tmp_path, name) as served:
        page = served.page()
        page.until(lambda state: state["link"])
        assert page.order("give", to="page")["error"] == 0
        page.until(lambda state: state["owner"] == "page")
        assert page.hello["turns"] == ("a" if name == "router_4axis" else "")
        if "step" not in page.hello["can"]:  # a kit: its motors turn, and nobody knows how far
            assert "turning" in page.hello["can"] and "motors" in page.state
            return
        for order, fields in (("unlock", {}), ("output", {"name": "motors_on"})):
            page.order(order, **fields)
        before = page.until(lambda state: "m" in state)["m"]
        assert page.order("step", by={"x": 2}, speed=60)["error"] == 0
        state = page.until(lambda state: state["m"][0] != before[0] and state["state"] in ("Idle", "Stopped"))
        assert abs(state["m"][0] - before[0] - 2) < 0.11


SQUARE = "MOVE 100 100  # a square\nLINE 300 100\nLINE 300 300\nLINE 100 300\nLINE 100 100\nEND\n"
UPLOADS = (("plotter_2014", "square.txt", SQUARE, "SQUARE.TXT", "odd.txt", "CIRCLE 5\n"),
           ("lpt_router", "square.txt", "[+500(" + "A" * 99 + "\n" + "G" * 40 + ")]\n", "SQUARE.TXT", "empty.txt", " \n"),
           ("router_3axis", "peça 1.gcode", "G21 G91 F3000\r\nG1 X4\r\nY4\r\nX-4\r\n" * 9, "PECA_1.GCODE", "photo.nc", "\x89PNG\0\n"))  # fmt: skip


@pytest.mark.parametrize("name, file, text, kept, wrong, wrong_text", UPLOADS)
@pytest.mark.skipif(not (CHROMIUM and DRIVER), reason="NO BROWSER: apt-get install chromium chromium-driver, to test the page")
def test_a_job_is_uploaded_to_the_board(tmp_path, name, file, text, kept, wrong, wrong_text):
    """The browser packs the job, the board's flash keeps it, and the board runs it; a file that is no job gets an error with its name."""
    language = boards.load(name)["links"][0]["protocol"]
    with Served(tmp_path, name, jobs={"language": language}) as served, Browser(served) as browser:
        browser.click("take")
        browser.until(lambda: browser.text("owner") == "this page")
        if browser.text("state") == "Alarm":
            browser.click("unlock")
        browser.until_state("Ready")
        browser.until(lambda: browser.find("kept-upload").is_enabled() and "MB free" in browser.text("kept-free"))
        for each, content in ((wrong, wrong_text), (file, text)):
            (tmp_path / each).write_text(content, newline="")
            browser.find("kept-upload").send_keys(str(tmp_path / each))
            browser.until(lambda: "is no job" in browser.text("message") if each == wrong else kept in browser.find("kept").text)
        browser.until(lambda: "Kept on the board" in browser.text("job-state"))
        assert not browser.find("keep").is_displayed() and not browser.find("kept-check").is_displayed()
        browser.shot(f"board-kept-{language}")
        browser.click("kept-run")
        browser.until(lambda: f"{kept}: Done" in browser.text("job-state"))
        browser.until_state("Ready")
        browser.until(lambda: browser.find("kept-remove").is_enabled())
        browser.click("kept-remove")
        browser.answer()
        browser.until(lambda: kept not in browser.find("kept").text)
        assert not [entry for entry in browser.driver.get_log("browser") if entry["level"] == "SEVERE"]


@pytest.mark.skipif(not (CHROMIUM and DRIVER), reason="NO BROWSER: apt-get install chromium chromium-driver, to test the page")
def test_in_a_browser(tmp_path):
    """The page hides the parts that a board leaves out, and the rest works."""
    with Served(tmp_path) as served, Browser(served) as browser:
        assert not browser.find("card-teach").is_displayed() and not browser.find("jobs").is_displayed()
        assert browser.find("hold").is_displayed()
        browser.click("take")
        browser.until(lambda: browser.text("owner") == "this page")
        browser.until(browser.find("unlock").is_enabled)
        browser.click("unlock")
        browser.until(lambda: browser.text("state") == "Ready")
        faults = [entry for entry in browser.driver.get_log("browser") if entry["level"] == "SEVERE"]
        assert not faults
        shots = os.environ.get("PASSO_SHOTS")
        if shots:
            browser.driver.save_screenshot(f"{shots}/board.png")
