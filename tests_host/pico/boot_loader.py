"""An emulated Pico with its boot loader: a folder stands for the drive that the PC sees.

    python boot_loader.py FIRST.uf2 FOLDER [BLOCKS]

prints `usb: URL`, the port of the running board. machine.bootloader(), or SIGUSR1 (BOOTSEL held while it is plugged in), makes FOLDER with
INFO_UF2.TXT in it. A UF2 laid there is written to the flash, block by block; behind the last one FOLDER goes, and the board starts. With BLOCKS the power goes
after that number of blocks of the first file, and comes again without BOOTSEL.
"""

import shutil
import signal
import sys
from pathlib import Path

FOLDERS = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(FOLDERS), str(FOLDERS / "firmware")]

from host_tools.emulator.pico import EmulatedPico  # noqa: E402
from host_tools.sim.serial_line import TcpLine, wait_for_bytes  # noqa: E402
from host_tools.uf2_format import BLOCK_BYTES, FLASH, PAGE  # noqa: E402

SECTOR = 4096
INFO = "INFO_UF2.TXT"
SLICE_US = 2000
IDLE_MS = 20
# The value that the ROM leaves in the watchdog before it resets into the boot loader, and its address.
_SCRATCH, _MAGIC, _ROM_END = 0x0C, 0xB007C0D3, 0x4000


class Board:
    def __init__(self, uf2, drive, cut=None):
        self.drive, self.cut = Path(drive), cut
        self.pico = EmulatedPico(files={}, uf2=uf2)
        self.loading = False
        self._watch()

    def _watch(self):
        watchdog = self.pico.chip.watchdog
        plain = watchdog.on_watchdog_trigger

        def triggered():
            words = [watchdog.read_uint32(_SCRATCH + 4 * number) for number in range(8)]
            if words[4] == _MAGIC and words[7] < _ROM_END:
                self.loading = True
                self.pico.stop()
            plain()

        watchdog.on_watchdog_trigger = triggered

    def started(self, flash):
        """The power goes and comes: only the flash is left."""
        self.pico._build_chip(None)
        self.pico.chip.flash[:] = flash
        self._watch()
        self.pico.boot(given_up=lambda: self.pico.now_us > 3_000_000)  # it may hold nothing that starts

    def bootsel(self):
        self.loading = True

    def load(self):
        """In the boot loader: offers the drive; once a file is there whole, writes it and starts."""
        self.drive.mkdir(exist_ok=True)
        (self.drive / INFO).write_text("UF2 Bootloader v3.0\nModel: Raspberry Pi RP2\nBoard-ID: RPI-RP2\n")
        for path in self.drive.glob("*.uf2"):
            data = path.read_bytes()
            blocks = len(data) // BLOCK_BYTES
            if not blocks or blocks < int.from_bytes(data[24:28], "little"):
                continue  # it waits for the rest
            self._write(data, blocks if self.cut is None else self.cut)
            self.cut = None
            shutil.rmtree(self.drive)
            self.loading = False
            try:
                self.started(bytes(self.pico.chip.flash))
            except Exception as fault:  # code that is not there: a real one stands
                print(f"fault: {fault}", flush=True)

    def _write(self, data, count):
        flash, erased = self.pico.chip.flash, set()
        for at in range(0, count * BLOCK_BYTES, BLOCK_BYTES):
            address = int.from_bytes(data[at + 12 : at + 16], "little") - FLASH
            if address // SECTOR not in erased:
                erased.add(address // SECTOR)
                begin = address // SECTOR * SECTOR
                flash[begin : begin + SECTOR] = b"\xff" * SECTOR
            flash[address : address + PAGE] = data[at + 32 : at + 32 + PAGE]


def main(uf2, drive, blocks=None):
    board = Board(Path(uf2), drive, blocks and int(blocks))
    stopped = []
    signal.signal(signal.SIGTERM, lambda *_: stopped.append(True))
    signal.signal(signal.SIGUSR1, lambda *_: board.bootsel())
    usb = TcpLine(0)
    board.pico.boot()
    print(f"usb: {usb.name}", flush=True)
    while not stopped:
        if board.loading:
            usb.read()
            board.load()
            wait_for_bytes([usb], IDLE_MS)
            continue
        if board.pico.usb.up:
            board.pico.usb.write(usb.read())
        try:
            board.pico.run(SLICE_US)
        except Exception as fault:  # it stands until somebody pulls its plug
            print(f"fault: {fault}", flush=True)
            while not stopped and not board.loading:
                wait_for_bytes([usb], IDLE_MS)
        said = board.pico.console.take_output()
        if said:
            usb.write(said)
        else:
            wait_for_bytes([usb], 1)
    usb.close()


if __name__ == "__main__":
    main(*sys.argv[1:])
