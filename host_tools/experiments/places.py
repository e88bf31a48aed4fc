"""The machines on which experiments are measured: the virtual machine, the emulated Pico, a board on a serial port.

    with place_of("emulated") as place:
        place.kind                          # "virtual", "emulated" or "board"
        place.create_machine("mill_2004")   # a machine with a plant: send, run_until, plant, trace; not of a board
        place.start_chip("plotter_2014")    # a connection to its MicroPython (host_tools/prove/connection.py); not of "virtual"

An emulated Pico is loaded once for each board file; `create_machine` makes one anew. A chip starts in the raw REPL with main.py not run, and its outputs are made
safe first. Raises Failure with the remedy if there is no UF2, no emulator or no board.
"""

from host_tools.failure import Failure
from host_tools.language import N_, _
from host_tools.prove.row import program_text as program_of_prove

VIRTUAL, EMULATED, BOARD = "virtual", "emulated", "board"
TITLES = {VIRTUAL: N_("virtual machine"), EMULATED: N_("emulated Pico"), BOARD: N_("board on {}")}
COMPILED_S = 0.3  # until main.py takes Ctrl-C, where misses of the flash cache count, too
START_S = 15  # of a board that begins its own work
SAFE = "from board import BOARD\nfrom passo.ports.safe import outputs, safe\nsafe(outputs(BOARD))"


def place_of(name, moves=False):
    """Return the place `name`: virtual, emulated or a serial port; `moves`: pins of a board may be driven. Raises Failure."""
    if name == VIRTUAL:
        return Virtual()
    if name == EMULATED:
        return Emulated()
    return OnPort(name, moves)


class Virtual:
    """The virtual machine, on this PC: it has no chip."""

    kind, moves = VIRTUAL, True

    def __enter__(self):
        return self

    def __exit__(self, *_error):
        pass

    def title(self):
        """Return the place's name for people."""
        return _(TITLES[VIRTUAL])

    def create_machine(self, board, **options):
        """Return a virtual machine of a board file. `options`: those of sim.machine.Machine."""
        from host_tools.sim.machine import VirtualMachine

        return VirtualMachine(board, **options)


class Emulated(Virtual):
    """The emulated Pico."""

    kind = EMULATED

    def __init__(self):
        """Load the emulator. Raises Unavailable if there is none, or no UF2, before anything is built."""
        from host_tools.emulator.binary import find_uf2, load_emulator

        load_emulator()
        find_uf2()  # raises Unavailable before anything is built
        self._chips = {}

    def title(self):
        """Return the place's name for people."""
        return _(TITLES[EMULATED])

    def create_machine(self, board, **options):
        """Return an emulated machine of a board file, started, with its links open. Takes some seconds."""
        from host_tools.emulator.machine import EmulatedMachine

        machine = EmulatedMachine(board, **options).boot()
        machine.run_until(machine.is_listening, 12_000)
        return machine

    def start_chip(self, board):
        """Return the emulated Pico of a board file, its interpreter started anew. Raises Failure."""
        from host_tools.prove.connection import EmulatedBoard

        if board not in self._chips:
            self._chips[board] = EmulatedBoard(board)
            self._chips[board].wait_s(COMPILED_S)
        return start(self._chips[board])


class OnPort:
    """A board on a serial port: it has a chip, and no plant to look into."""

    kind = BOARD

    def __init__(self, port, moves):
        """Take the board on `port`; `moves`: its pins may be driven."""
        from host_tools.prove.connection import PortBoard

        self._port = port
        self.moves = moves
        self._board = PortBoard(port)
        self._raw = None

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self._board.__exit__(*(error or (None,)))

    def title(self):
        """Return the place's name for people."""
        return _(TITLES[BOARD], self._port)

    def start_chip(self, _board):
        """Return the board, its interpreter started anew. Raises Failure."""
        return start(self._board)

    def connection(self):
        """Return the board without a new start."""
        return self._board

    def board_table(self):
        """Return the table of the board's own board file. Raises Failure if it has none."""
        from host_tools.prove.connection import board_file_of

        if self._raw is None:
            self._raw = board_file_of(self._board)
        return self._raw

    def open_client(self):
        """Return a client of G-code, of the board at its own work. Do not call start_chip() from then on."""
        from host_tools.clients.grbl import GrblClient

        self._board.close()
        return GrblClient(self._port, timeout_s=START_S)


def start(board):
    """Start the board's interpreter anew, with safe outputs and motors off; return the board. Raises Failure if it has no Passo."""
    board.restart_interpreter()
    try:
        board.exec(SAFE)
    except Failure as failure:
        raise Failure("{} has no Passo: {}. passo flash puts one there", board.name, failure) from None
    return board


def program_text(name):
    """Return the text of a program of host_tools/experiments or host_tools/prove for the board."""
    from pathlib import Path

    own = Path(__file__).parent / name
    return own.read_text(encoding="utf-8") if own.is_file() else program_of_prove(name)
