"""Every verb of `passo` that opens a port, at a machine that is at work for another program, in each language: it goes on as if nobody had
come, and its log has nothing more.
"""

import threading
import time

import pytest
import serial
from test_board_command import passo

from host_tools import boards
from host_tools.sim.machine import Machine
from host_tools.sim.serial_line import PtyLine, wait_for_bytes
from passo import errors
from passo.config.boardfile import check
from passo.ports.virtual import MemoryLine
from passo.protocols.plotter.host import COMMANDS, packet
from passo.protocols.pulses.protocol import frame

pytestmark = [pytest.mark.unmeasured, pytest.mark.xdist_group("at work")]
SVG = '<svg xmlns="http://www.w3.org/2000/svg" width="10mm" height="10mm" viewBox="0 0 10 10"><path d="M1 1L9 9" stroke="black"/></svg>'
# Jobs of minutes in each language.
WORK = {
    "router_3axis": b"$X\nG91M3S900\nG1X60F10\n",
    "plotter_2014": packet(COMMANDS["SPEED"], 20_000) + packet(COMMANDS["LINE"], 1200, 450) + packet(COMMANDS["END"]),
    "lpt_router": frame("speed 60") + frame("stream") + b"[+60" + b"A" * 400 + frame("end"),
}
# Verbs with their arguments besides the port, and their answer.
VERBS = {
    "router_3axis": [
        ("status", "Run"), ("log", ""), ("link --protocol grbl", "commands"), ("watch --once", "Run"), ("settings show", "at work (Run)"),
        ("settings backup mine.txt", "at work (Run)"), ("calibrate table.csv", "at work (Run)"), ("check part.gcode", "at work (Run)"),
        ("stream part.gcode", "at work (Run)"), ("stream --home part.gcode", "at work (Run)"), ("draw drawing.svg", ""), ("jobs list", "at work (Run)"),
        ("jobs store part.gcode", "at work (Run)"), ("machine list", "no MicroPython board answers"),
    ],
    "plotter_2014": [
        ("status --protocol plotter", "drawn"), ("log --protocol plotter", ""), ("link --protocol plotter", "no word"), ("watch --once --protocol plotter", "drawn"),
        ("draw drawing.svg", "stop it first"),
    ],
    "lpt_router": [
        ("status --protocol pulses", "state"), ("log --protocol pulses", ""), ("link --protocol pulses", "commands"), ("watch --once --protocol pulses", "state"),
    ],
}

LONG = ("machine list",)  # waits half a minute for the prompt


class AtWork:
    """A virtual machine in a thread, its first link on a pty, at work for a program that has left its port."""

    def __init__(self, name):
        board = boards.load(name)
        self.line = PtyLine()
        lines = {link["name"]: MemoryLine() for link in board["links"]}
        lines[board["links"][0]["name"]] = self.line
        self.machine = Machine(board, lines, "real", lambda ms: wait_for_bytes([self.line], ms), start=(0, 0, 0)[: len(board["axes"])])
        self._ends, self._failed = False, None
        self._thread = threading.Thread(target=self._loop, daemon=True)
        self._thread.start()

    def _loop(self):
        try:
            while not self._ends:
                self.machine.cycle()
        except Exception as error:  # told by looks()
            self._failed = error

    def begin(self, data):
        """Returns once it moves: before that, between a spindle's start and the first line, it is idle for a cycle."""
        stood = list(self.machine.plant.position)
        with serial.Serial(self.line.name, 115200, timeout=0.2) as client:
            client.write(data)
            end = time.monotonic() + 60
            while self.machine.app.controller.state not in ("run", "jog") or list(self.machine.plant.position) == stood:
                assert time.monotonic() < end, self.looks()
                client.read(100)
        return self.looks()

    def looks(self):
        """All that a visitor might change; not that this PC had no time for the machine."""
        assert self._failed is None, self._failed
        controller = self.machine.app.controller
        log = [entry[1:] for entry in controller.machine.log.entries if entry[1] != errors.WORDS_LATE]
        return controller.state, log, list(self.machine.plant.errors)

    def moves_on(self):
        before = list(self.machine.plant.position)
        end = time.monotonic() + 60
        while list(self.machine.plant.position) == before:
            assert time.monotonic() < end, "it stands"
            time.sleep(0.02)

    def close(self):
        self._ends = True
        self._thread.join()
        self.machine.close()
        self.line.close()


@pytest.fixture(scope="module")
def at_work(request):
    """(the machine, what it looks like) of a board's name."""
    running = AtWork(request.param)
    try:
        yield running, running.begin(WORK[request.param])
    finally:
        running.close()


@pytest.fixture
def files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "part.gcode").write_text("G21G90\nG1X5F600\nM2\n")
    (tmp_path / "drawing.svg").write_text(SVG)
    (tmp_path / "table.csv").write_text("x,10,10.1\nx,20,20.2\nx,50,50.5\n")


@pytest.mark.parametrize("at_work, verb, answer", [pytest.param(name, *row, marks=pytest.mark.slow if row[0] in LONG else ()) for name, rows in VERBS.items() for row in rows], indirect=["at_work"])
def test_a_machine_at_work_notices_nobody(at_work, verb, answer, files):
    running, before = at_work
    done = passo(*verb.split(), "--port", running.line.name)
    assert answer in done.stdout + done.stderr
    assert running.looks() == before
    running.moves_on()


def test_nobody_waits_for_a_visitor(files):
    """A program that only asks, twice, at a machine whose host does not, is not taken for the host, whose silence would end the job (lost)."""
    lost_s = check(boards.load("router_3axis"))["links"][0]["lost_ms"] / 1000
    running = AtWork("router_3axis")
    try:
        before = running.begin(WORK["router_3axis"])
        time.sleep(lost_s + 0.5)
        for _ in range(2):
            assert "at work" in passo("check", "part.gcode", "--port", running.line.name).stderr
        time.sleep(lost_s + 1)
        assert running.looks() == before
        running.moves_on()
    finally:
        running.close()
