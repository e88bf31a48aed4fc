"""A whole machine in memory: the firmware on the virtual port, wired to a plant, with serial lines of bytes.

    machine = VirtualMachine("plotter_2014", start=(300, 200), bounce_ms=3)
    machine.send(packet(COMMANDS["ORIGIN"]))
    machine.run_until(lambda: machine.replies_so_far() == b"o", 60_000)
    machine.plant.position, machine.trace.rows(), machine.plant.errors

Time is virtual throughout, link time-outs included, so that a run is the same every time and waits for nothing.
"""

import sys
import tempfile
from pathlib import Path

from host_tools import boards
from host_tools.failure import reason
from host_tools.language import _
from host_tools.sim.pages import Pages
from host_tools.sim.plant import Plant
from host_tools.sim.recording import Recording
from host_tools.sim.tmc import SimDrivers
from host_tools.sim.tmc_spi import SpiDrivers
from passo.app import App
from passo.config.boardfile import check
from passo.config.journal import FileSlots
from passo.ports.virtual import MemoryLine, VirtualPort
from passo.ports.virtual_player import Player

STAND_STILL_MS = 600_000
LAST_TICKS = 12_500_000  # the machine is watched for another second after the board has stopped


class _Slots(FileSlots):
    """Files of the settings. Prints the reason if they cannot be saved, beside the firmware's error."""

    def write(self, slot, data):
        """Write a slot's file. Prints the cause of an OSError and raises it again."""
        try:
            FileSlots.write(self, slot, data)
        except OSError as error:
            print(_("cannot write {}: {}", self._slot_path(slot), reason(error)), file=sys.stderr, flush=True)
            raise


class Machine:
    """The firmware on a virtual port. `board` is a board's name or dict, `lines` maps link names to serial lines,
    `trace` and `vcd` are files' paths (None: none; True: the trace is kept in memory), `plant_options` go to Plant.
    `radio`: the network of a board file that has one, as host_tools.sim.radio; None: it is off.
    `flash`: the folder that stands for the board's flash: settings and stored jobs; None: they last as long as the machine.
    `slots`, `pages`: storages of the settings and of the job's journal, instead of that folder.
    `plant`, `player`: the classes of the model at the pins, and of the player of words.
    `inverter`: a SimInverter, if the board file has one.
    `idle`: False leaves idle time out of the trace: only the time that the PC thinks differs from run to run."""

    def __init__(
        self, board, lines, mode, sleep=None, protocols=None, trace=None, vcd=None, idle=True, inverter=None, radio=None, flash=None, pages=None, slots=None,
        plant=Plant, player=Player, **plant_options
    ):
        loaded = boards.load(board) if isinstance(board, str) else board
        self.board = check(loaded)
        self.plant = plant(self.board, **plant_options)
        self._files = files = Recording(self.board, self.plant, trace, vcd)
        self.trace = files.trace
        self.port = None
        self.inverter = None
        if self.board.get("inverter"):
            from host_tools.sim.inverter import SimInverter

            self.inverter = inverter or SimInverter(self.board["inverter"], self.now_ms)
            lines = {**lines, "inverter": self.inverter}
        self.drivers = None
        if self.board.get("drivers"):
            self.drivers = SimDrivers(self.board["drivers"], self.now_ms)
        elif self.board.get("spi_drivers"):
            self.drivers = SpiDrivers(self.board["spi_drivers"])
        if self.drivers:
            lines = {**lines, "drivers": self.drivers}
        if self.plant.slipping:
            self.plant.slipping.wire_drivers(self.drivers)
        self.port = VirtualPort(self.board, files.world, mode, lines, sleep, player=player, radio=radio)
        if self.board.get("journal"):
            self.port.pages = pages or Pages(Path(flash) / "pages" if flash else None)
        self.port.folder = str(Path(flash) / "jobs") if flash else self._own_folder()
        slots = slots or (_Slots(str(Path(flash) / "settings")) if flash else None)
        self.app = App(check(loaded), self.port, protocols, slots)
        self._homing = False
        self._idle = idle

    def _own_folder(self):
        """Stored jobs that last as long as the machine."""
        if not self.board.get("jobs"):
            return None
        self._folder = tempfile.TemporaryDirectory(prefix="passo-")
        return self._folder.name

    def now_ms(self):
        """Return the virtual milliseconds since the start, a float."""
        return self.port.now / 12_500 if self.port else 0.0

    def cycle(self):
        """Run one cycle of the firmware's main loop."""
        app = self.app
        app.poll()
        homing = app.controller.state == "home"
        if self._homing and not homing and app.controller.machine.homed and self.trace:
            self.trace.rezero(self.plant.position)
        self._homing = homing
        self._pass_time(app.controller.busy(), homing)

    def _pass_time(self, busy, homing):
        """Let a cycle's time pass on the port. At rest the trace leaves this time out, unless `idle` is to be traced."""
        port = self.port
        if self._idle or not self.trace or port.pending(busy):
            port.wait(busy, homing)
            return
        before = port.now
        port.wait(busy, homing)
        self.trace.skip_ticks(port.now - before)

    def flush(self):
        self._files.flush()

    def close(self):
        """Halt, outputs safe, let the pen come up, and close the files."""
        try:
            self.app.stop()
            self.port.advance(LAST_TICKS)
        finally:
            self._files.close()


class VirtualMachine(Machine):
    """A Machine for tests: stepped time and lines in memory."""

    def __init__(self, board="plotter_2014", protocols=None, trace=True, vcd=None, **plant_options):
        loaded = boards.load(board) if isinstance(board, str) else board
        self.lines = {link["name"]: MemoryLine() for link in loaded["links"]}
        self.first = loaded["links"][0]["name"]
        super().__init__(loaded, self.lines, "stepped", None, protocols, trace, vcd, **plant_options)

    def send(self, data, link=None):
        """Put bytes on a link, the first one unless named."""
        self.lines[link or self.first].incoming += bytes(data)

    def replies_so_far(self, link=None):
        """Return the bytes that the board has sent on a link so far; they stay there until `take`."""
        return self.lines[link or self.first].outgoing

    def take(self, link=None):
        """Return the bytes that the board has sent since the last `take`."""
        line = self.lines[link or self.first]
        data, line.outgoing = line.outgoing, b""
        return data

    def run_until(self, condition, limit_ms=60_000):
        """Run cycles until condition() holds. Raises TimeoutError after `limit_ms` of virtual time."""
        end = self.now_ms() + limit_ms
        while not condition():
            if self.now_ms() >= end:
                raise TimeoutError(f"not within {limit_ms} virtual ms; state {self.app.controller.state}")
            self.cycle()

    def run_ms(self, milliseconds):
        """Run for `milliseconds` of virtual time, or a quantum more."""
        end = self.now_ms() + milliseconds
        self.run_until(lambda: self.now_ms() >= end, milliseconds + 1)

    def settle(self, limit_ms=STAND_STILL_MS):
        """Run cycles until nothing moves and nothing is pending. Raises TimeoutError after `limit_ms` of virtual time."""
        self.cycle()
        self.run_until(lambda: not self.port.pending(self.app.controller.busy()), limit_ms)

    def ask(self, data, answers=1, limit_ms=STAND_STILL_MS, link=None):
        """Send bytes and return the answer, once it has `answers` bytes."""
        self.take(link)
        self.send(data, link)
        self.run_until(lambda: len(self.replies_so_far(link)) >= answers, limit_ms)
        return self.take(link)
