"""A whole machine: the firmware of a board file on an emulated Pico, its pins wired to a plant.

    machine = EmulatedMachine("plotter_2014", start=(300, 200))
    machine.boot()
    machine.ask(packet)                     # over UART0 at the board file's baud rate
    machine.plant.position, machine.trace.rows(), machine.plant.errors

It has the methods of `host_tools.sim.machine.VirtualMachine`, in emulated time. `board` is a name, the path of a
board file, or a dict. `files` replaces the firmware ({} is a blank Pico, None the compiled firmware of the board).
"""

import tempfile
from functools import lru_cache
from pathlib import Path

from host_tools import boards
from host_tools.build.tree import build_tree
from host_tools.emulator.cycles import CYCLES_PER_TICK
from host_tools.emulator.filesystem import folder_files
from host_tools.emulator.homing import HomingWatch
from host_tools.emulator.tmc import WiredDrivers, WiredSpiDrivers
from host_tools.emulator.pico import EmulatedPico
from host_tools.emulator.wire import UsbWire
from host_tools.emulator.wiring import Wiring
from host_tools.failure import Failure
from host_tools.sim.plant import Plant
from host_tools.sim.recording import Recording
from passo.config.boardfile import check

STAND_STILL_MS = 600_000
QUIET_MS = 100  # without an edge or a byte: longer than any pause of a machine that is under way
LAST_TICKS = 12_500_000  # the machine is watched for another second after the power has gone


@lru_cache(maxsize=8)
def firmware_files(board):
    """Return {path: bytes} of the compiled firmware of a board, by name or path."""
    with tempfile.TemporaryDirectory() as folder:
        build_tree(board, Path(folder))
        return folder_files(folder)


def files_of(board):
    """Return {path: bytes} of the compiled firmware of a board given as a dict; `BOARD = {…}` stands in board.py."""
    return _files_of_text(f"BOARD = {board!r}\n")


@lru_cache(maxsize=8)
def _files_of_text(text):
    """Return the firmware's files for the text of a board file, as firmware_files() does for a path; keeps the last eight."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "board.py"
        path.write_text(text, encoding="utf-8")
        return firmware_files.__wrapped__(str(path))


class EmulatedMachine:
    def __init__(self, board="plotter_2014", files=None, trace=True, vcd=None, uf2=None, leave_out=(), **plant_options):
        loaded = board if isinstance(board, dict) else boards.load(board)
        if loaded.get("chip") != "rp2040":
            raise Failure("an RP2040 is emulated, and the board file is for {}", loaded.get("chip"))
        self.board = check(loaded)
        if files is None:
            files = files_of(board) if isinstance(board, dict) else firmware_files(str(board))
        self.pico = EmulatedPico(files=files or None, uf2=uf2, leave_out=leave_out)
        self.plant = Plant(self.board, **plant_options)
        self._files = files = Recording(self.board, self.plant, trace, vcd)
        self.trace = files.trace
        self.wiring = Wiring(self.pico, self.board, files.world, self.plant)
        self._links = {link["name"]: link for link in self.board["links"]}
        self._first = self.board["links"][0]["name"]
        self._usb = UsbWire(self.pico)
        self.inverter = None
        if self.board.get("inverter"):
            from host_tools.emulator.inverter import WiredInverter

            self.inverter = WiredInverter(self.pico, self.board["inverter"])
        self.drivers = WiredDrivers(self.pico, self.board["drivers"]) if self.board.get("drivers") else None
        if self.board.get("spi_drivers"):
            self.drivers = WiredSpiDrivers(self.pico, self.board["spi_drivers"])
        if self.plant.slipping:
            self.plant.slipping.wire_drivers(self.drivers.model)
        self._watches = {name: HomingWatch(link["protocol"], self._zero_trace) for name, link in self._links.items()}
        for name in self.uart_links():
            self.wire(name).listeners.append(self._watches[name].note_answer)

    def uart_links(self):
        """Return the names of the links on UARTs."""
        return [name for name, link in self._links.items() if link["port"].startswith("uart")]

    def wire(self, link=None):
        """Return the `Wire` of a link, of the first one unless named; the `UsbWire` of one on USB."""
        if self._links[link or self._first]["port"] == "usb":
            return self._usb
        return self.pico.uart(self.uart_number(link or self._first))

    def is_listening(self):
        """True once the firmware has opened the UARTs of all links: it answers bytes sent from then on."""
        return all(self.pico.chip.uart[self.uart_number(name)].enabled for name in self.uart_links())

    def uart_number(self, link):
        """Return the number of the UART of a link."""
        return int(self._links[link]["port"][4:])

    def _zero_trace(self):
        if self.trace:
            self.trace.rezero(self.plant.position)

    # --- time

    def boot(self, given_up=None):
        """Switch on, and run until USB is up, which is before main.py starts; or until given_up() is true."""
        self.pico.boot(given_up=given_up)
        return self

    def now_ms(self):
        """Return the emulated milliseconds since power-on."""
        return self.pico.now_us / 1000

    def run_ms(self, milliseconds):
        """Let emulated time pass."""
        self.pico.run(milliseconds * 1000)

    def run_until(self, condition, limit_ms=60_000, slice_us=1000):
        """Run until condition() holds, asked once a slice. Raises TimeoutError after `limit_ms` of emulated time."""
        if not self.pico.run_until(condition, limit_ms * 1000, slice_us):
            raise TimeoutError(f"not within {limit_ms} emulated ms")

    def settle(self, limit_ms=STAND_STILL_MS):
        """Run until the machine and its links have been still for a while."""
        end = self.now_ms() + limit_ms
        before = None
        while before != (before := self._activity()):
            if self.now_ms() >= end:
                raise TimeoutError(f"not still within {limit_ms} emulated ms")
            self.run_ms(QUIET_MS)

    def _activity(self):
        wires = [self.wire(name) for name in self._links]
        return self.wiring.edge_count, [(wire.pending, wire.count) for wire in wires]

    # --- links

    def send(self, data, link=None):
        """Put bytes on a link's wire."""
        name = link or self._first
        self._watches[name].note_sent(data)
        self.wire(name).feed(data, self._links[name]["baud"])

    def replies_so_far(self, link=None):
        """Return the bytes that the board has sent on a link; they stay there until `take`."""
        return bytes(self.wire(link).output)

    def take(self, link=None):
        """Return the bytes that the board has sent since the last `take`."""
        return self.wire(link).drain()

    def ask(self, data, answers=1, limit_ms=STAND_STILL_MS, link=None):
        """Send bytes and return the answer, once it has `answers` bytes."""
        self.take(link)
        self.send(data, link)
        self.run_until(lambda: len(self.wire(link).output) >= answers, limit_ms)
        return self.take(link)

    # --- the end

    def flush(self):
        self._files.flush()

    def close(self):
        """Take the power away, let the pen come up, and close the files."""
        try:
            self.wiring.unplug()
            self.plant.run(self.pico.cycle // CYCLES_PER_TICK + LAST_TICKS)
        finally:
            self._files.close()
