"""Every command that a document shows in a block, run by the installed `passo` in the order of its page, at a virtual board that speaks what is asked.

Guides and README have tests of their own (test_install.py). A command that interrupts is killed amid its work, and one that serves is
ended by Ctrl-C. Commands that only a chip or another PC answers are in ELSEWHERE, with the test that runs them.
"""

import re
import signal
import time
import zlib

import pytest
import serial
from test_docs import PAGES, shown_commands
from test_install import GUIDES, SVG, emptied, good, passo, wheel  # noqa: F401

from host_tools import boards
from host_tools.resources import ROOT

pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("install")]
# Words of commands, and the tests that run those.
ELSEWHERE = {
    ("prove", "--port"): "tests_host/pico/test_pico_prove.py",
    ("blackbox",): "tests_host/options/blackbox/test_blackbox_command.py",
    ("machine",): "tests_host/tools/test_machine.py",
    ("link",): "tests_host/tools/test_board_command.py",
    ("wifi", "access"): "tests_host/options/network/test_wifi_command.py",
    ("flash", "--uf2"): "tests_host/tools/test_flash_uf2.py",
    ("wifi", "bridge"): "tests_host/tools/test_websocket_line.py",
    ("--dask",): "tests_host/tools/test_check_folder.py",
    ("experiments", "--on"): "tests_host/pico/test_pico_experiments.py",
    ("agent",): "tests_host/tools/test_agent.py",
    ("shop",): "tests_host/tools/test_shop.py",
}
SERVES = ("board", "panel", "site", "wifi")  # until they are ended
# "And something fails", say jobs.md and plotter.md.
INTERRUPTED = {("jobs.md", "stream examples/part.gcode --home"), ("jobs.md", "draw examples/map.svg --center"), ("plotter.md", "draw examples/map.svg")}
NEEDS_PORT = ("jobs", "resume", "stream", "draw", "torch", "pulses play", "send", "log", "settings", "keys")
NO_PORT = ("--port", "--dry-run", "--packets", "-o", "--pattern", "--card", "--help")


def strokes(length):
    """Return a drawing of 1500 strokes of this length, in mm: more than a board stores."""
    return SVG.replace("M5 5 L35 5", "M5 5 " + "".join(f"L{5 + row / 50:.2f} {5 + length * (row % 2)} " for row in range(1500)))


# The job that jobs.md interrupts runs at the machine's pace: more points than a board stores, for a minute.
LONG = {"jobs.md": ("examples/map.svg", 1)}
ZERO = ("$H", "G53 G0 X100 Y100 Z-60", "G10 L20 P1 X0 Y0 Z0")  # of a router: at the workpiece
REFUSED = {"send --port /tmp/plotter LINE 5000 10 STATUS": "error 104", "torch move 1 1 --port /tmp/torch": "error 117",
           "check examples --board router_3axis --workers 2 -o table.csv": "error 340"}  # as their pages show
TOOLS = 9  # that a program changes at most
WRITTEN_S = 120  # until a job that homes first is in the journal


def language(words):
    """The board that a command without one wants."""
    text = " ".join(words)
    if "pulses" in words or "hexagon" in text.lower():
        return "lpt_router"
    if "torch" in words:
        return "torch_manipulator"
    if "keys" in words:
        return "two_motor_kit"
    if "plotter" in words or "send" in words or "draw" in words and "router_3axis" not in words or "examples/map.svg" in words:
        return "plotter_2014"
    return "router_3axis"
class Reader:
    """A reader who follows a page: a folder of files, and virtual boards, of which one at a time is on."""

    def __init__(self, passo, page, folder):  # noqa: F811
        self._passo, self._page, self._folder = passo, page, folder
        self._running = {}  # the processes that serve: their words
        self.link = folder / "port"
        self._on = self._flash = None

    def command(self, words):
        """Run it: (exit status, what it said). A command that serves goes on."""
        refused = REFUSED.get(" ".join(words))
        words = [str(self.link) if word.startswith(("/tmp/", "/dev/tty")) else str(self._folder) if word.startswith("/media/") else word for word in words]
        if words[0] == "plot":
            self.end()
        if words[0] == "board":
            self.end()
            self._on = "as the page has it"
            self._serve(words)
            return self._zero() if "router_3axis" in words else None
        if words[0] == "flash":
            words = [*[word for word in words if word not in ("--port", str(self.link))], "--dry-run"]
        elif self._at_board(words):
            if "--port" not in words:
                words += ["--port", str(self.link)]
            self._switch_on(language(words))
        if words[0] in SERVES:
            return self._serve(words)
        if (self._page, " ".join(words).partition(" --port ")[0]) in INTERRUPTED and words[-1] != "--continue":
            return self._interrupt(words)
        if words[:3] == ["resume", "hexagon.txt", "--unverified"]:
            self._interrupt(["pulses", "play", "hexagon.txt", "--stream", "--repeat", "9", "--port", str(self.link)])
        if words[0] == "resume" or words[0] == "stream" and "--from" in words:  # else somebody is asked
            words += ["--yes"]
        if words == ["ports"]:  # those of this PC
            refused = "no board is connected"
        return self._run(words, refused)

    def _at_board(self, words):
        text = " ".join(word for word in words if not word.startswith("--frames") and word != "--no-frames")
        return "--port" in words or text.startswith(NEEDS_PORT) and not any(word in words for word in NO_PORT) and "pulses" not in words[:1]

    def _run(self, words, refused=None):
        done = self._passo(*words, keys="\n" * TOOLS)  # Enter once each is in
        if refused and done.returncode:
            assert done.returncode == 1 and refused in done.stdout + done.stderr, done
        else:
            assert not done.returncode, f"{self._page}: passo {' '.join(words)}\n{done.stdout}{done.stderr}"
            assert not refused or words == ["ports"], f"{self._page}: passo {' '.join(words)} is not refused"

    def _zero(self):
        """Of a router, as its pages say before they stream a file."""
        with serial.Serial(str(self.link), 115200, timeout=60) as port:
            for line in ZERO:
                port.write(line.encode() + b"\n")
                assert port.read_until(b"ok\r\n").endswith(b"ok\r\n"), line
            report = b""
            while b"<Idle" not in report:
                port.write(b"?")
                report = port.read_until(b">")

    def _switch_on(self, name):
        if self._on in (name, "as the page has it"):
            return
        self.end()
        board = {**boards.load(name), "journal": {"every_ms": 500}}
        if name != "torch_manipulator" and name != "two_motor_kit":
            board["jobs"] = {"language": {"router_3axis": "grbl", "lpt_router": "pulses", "plotter_2014": "plotter"}[name]}
        else:
            del board["journal"]
        if self._page == "frames.md":
            board["links"] = [{**link, "frames": True} for link in board["links"]]
        own = self._folder / f"own_{name}.py"
        own.write_text(f'"""A board with a journal and jobs."""\n\nBOARD = {board!r}\n')
        pace = "real" if self._page == "jobs.md" else "fast"  # a job that is to be interrupted takes its real time
        self._flash = self._folder / f"flash_{name}"
        self._serve(["board", "--board", str(own), "--link", str(self.link), "--flash", str(self._flash), "--time", pace])
        self._on = name
        if name == "router_3axis":
            self._zero()
        elif name == "torch_manipulator":
            self._run(["torch", "connect", "--port", str(self.link)])

    def _serve(self, words):
        words = [word for word in words if word != "--open"]
        if words[0] == "site":
            if "--serve" not in words:
                return self._run(words)
            words[words.index("--serve") + 1] = "0"
        elif words[0] == "panel":
            words += ["--http", "0"]
        process = self._passo(*words, start=True)
        self._running[process] = words
        for line in process.stdout:
            if re.match("port|page|http|.*http://|.*Ctrl", line):
                return
        raise AssertionError(f"{self._page}: passo {' '.join(words)}: {process.stderr.read()}")

    def _interrupt(self, words):
        """Kill it once its journal has been written: the board's, several times, or the drawing's."""
        before, deadline = self._journal(), time.monotonic() + WRITTEN_S
        process = self._passo(*words, start=True)
        seen = set()
        while len(seen) < (4 if self._flash else 1):
            assert process.poll() is None and time.monotonic() < deadline, f"{self._page}: passo {' '.join(words)}: {len(seen)} records"
            seen |= {self._journal()} - {before}
            time.sleep(0.1)
        process.kill()
        process.wait()
        process.stdout.close()
        process.stderr.close()
        time.sleep(4)  # the board gives its host up

    def _journal(self):
        paths = self._flash.glob("pages") if self._flash else self._passo.folder.glob("examples/*.journal")
        return tuple((path.name, zlib.crc32(path.read_bytes())) for path in sorted(paths))

    def end(self):
        for process in self._running:
            process.send_signal(signal.SIGINT)
            assert process.wait(timeout=60) == 0, (self._running[process], process.stderr.read())
            process.stdout.close()
            process.stderr.close()
        self._running = {}
        self._on = None


def documents():
    """Pages with commands in blocks that no guide's test runs."""
    for page in PAGES:
        if "pt" not in page.parts and page not in GUIDES and page.name != "CHANGELOG.md":
            if shown_commands(page.read_text(encoding="utf-8"), "passo", mentioned=False):
                yield page


@pytest.mark.parametrize("page", [pytest.param(page, id=page.relative_to(ROOT).as_posix()) for page in documents()])
def test_every_command_in_a_block(passo, page, tmp_path):  # noqa: F811
    folder = emptied(passo)
    if longer := LONG.get(page.name):
        (folder / "examples").mkdir()
        (folder / longer[0]).write_text(strokes(longer[1]))
    reader = Reader(passo, page.name, tmp_path)
    try:
        for words in shown_commands(page.read_text(encoding="utf-8"), "passo", mentioned=False):
            if not words or any(set(key) <= set(words) for key in ELSEWHERE):
                continue
            reader.command(words)
    finally:
        reader.end()


def test_what_is_run_elsewhere_is():
    for words, file in ELSEWHERE.items():
        assert words[-1].strip("-") in (ROOT / file).read_text(encoding="utf-8"), (words, file)
