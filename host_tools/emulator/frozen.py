"""An emulated Pico with Passo's UF2: the firmware is in it, and the file system holds the board file.

    uf2 = find_frozen("rp2040")                     # raises Unavailable with the command that builds it
    machine = frozen_machine("router_3axis", uf2)   # an EmulatedMachine, as of stock MicroPython
    machine = boot_for_lines(board, uf2, texts)           # that waits for gcode.run_lines()
"""

from host_tools import boards
from host_tools.build.frozen import stamp
from host_tools.build.uf2 import path_of, label_of
from host_tools.emulator.binary import Unavailable, check_uf2
from host_tools.emulator.gcode import line_of_memory
from host_tools.emulator.heap import Heap
from host_tools.emulator.machine import EmulatedMachine

# In front of main.py, which is frozen: before the app runs its first link becomes the memory.
_ATTACH = b"""
import sys
sys.path.remove(".frozen")
sys.path.insert(0, ".frozen")
from passo.ports.rp2.start import Start
def run(self, app, port, real=Start.run):
    import memory_line
    memory_line.attach(app, port)
    real(self, app, port)
Start.run = run
"""


def find_frozen(name):
    """Return the path of the UF2 of this source for a chip. Raises Unavailable."""
    path = path_of(name)
    if not path.is_file():
        raise Unavailable("there is no UF2 of this source for the {0}: make uf2 CHIP={0}", name)
    if label_of(path) != (name, stamp(name)):
        raise Unavailable("{0} is not the UF2 of this source for the {1}: make uf2 CHIP={1}", path, name)
    return check_uf2(path)


def board_file(board):
    """Return {"board.py": …} of a board file's name or path, or of a dict."""
    text = f"BOARD = {board!r}\n".encode() if isinstance(board, dict) else boards.board_py(board)
    return {"board.py": text}


def frozen_machine(board, uf2, files=None, **options):
    """Return an EmulatedMachine with this UF2, not booted. `files`: {path: bytes} beside the board file."""
    return EmulatedMachine(board, {**board_file(board), **(files or {})}, uf2=uf2, **options)


def boot_for_lines(board, uf2, texts):
    """Boot a machine that waits for gcode.run_lines(); `texts`: its files."""
    files = {"boot.py": _ATTACH, **line_of_memory(), **texts}
    machine = frozen_machine(board, uf2, files, trace=None).boot()
    machine.pico.console.expect(b"ready")
    machine.free_bytes = int(machine.pico.console.expect(b"\n").split()[-1])
    return machine


class Started:
    """A machine that has answered: `heap` as if it had been collected then; `answered_ms` since power came; `said` on the console."""

    def __init__(self, board, uf2, question=b"?", answer=b"<", limit_ms=12_000, files=None):
        self.machine = machine = frozen_machine(board, uf2, files, trace=None).boot()
        link = next(iter(machine.uart_links()), None)  # None: USB
        said = b""
        while answer not in said and machine.now_ms() < limit_ms:
            machine.send(question, link)
            machine.run_ms(10)
            said += machine.take(link)
        self.answered_ms = machine.now_ms() if answer in said else None
        self.heap = Heap(machine.pico, True)
        self.said = bytes(machine.pico.console.text).decode(errors="replace")
