"""An emulated RP2350, Cortex-M33, with Passo's UF2: in emulated time, its USB, one serial line and its pins.

    chip = Rp2350({"board.py": text})       # booted as time passes; close() ends it
    chip.until(b"<", b"?")                  # sends "?" every 10 ms until "<" has come over USB
    chip.watch([2, 3]); chip.run(1000)      # chip.edges: [[cycle, pin, level], …]
    chip.exec("print(1)")                   # over the raw REPL, if no board file runs

The emulator is rp2350js (MIT, on GitHub), 2.0.1, run by node; PASSO_RP2350JS names its folder, built there by

    npm install --ignore-scripts && npx tsc

It runs the chip's own boot ROM, some ten to thirty times slower than the chip. rp2350.js, beside this file, mends what it does otherwise
than the chip. Not modelled: priorities of interrupts, the flash's cache, the time that erasing takes; so times are those of a chip
whose flash costs nothing.
"""

import json
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from host_tools.build.frozen import CHIPS, stamp
from host_tools.build.uf2 import path_of, label_of
from host_tools.emulator.binary import Unavailable
from host_tools.emulator.filesystem import BLOCK_BYTES, make_image

CYCLES_PER_US = 150
DRIVER = Path(__file__).with_name("rp2350.js")
CHIP = CHIPS["rp2350"]
SLICE_US = 10_000


def emulator():
    """The folder of the emulator's modules. Raises Unavailable."""
    named = os.environ.get("PASSO_RP2350JS")
    if not named or shutil.which("node") is None:
        raise Unavailable("PASSO_RP2350JS names no build of rp2350js, or there is no node")
    folder = Path(named) / "dist" / "cjs"
    if not folder.is_dir():
        raise Unavailable("{} is not built: npx tsc", named)
    return folder


def image():
    """The UF2 of this source. Raises Unavailable."""
    path = path_of(CHIP.name)
    if not path.is_file() or label_of(path) != (CHIP.name, stamp(CHIP.name)):
        raise Unavailable("there is no UF2 of this source for the {0}: make uf2 CHIP={0}", CHIP.name)
    return path


class Rp2350:
    def __init__(self, files, counter=True):
        with tempfile.NamedTemporaryFile(delete=False) as file:
            file.write(make_image(files, CHIP.storage // BLOCK_BYTES))
        self._image = file.name
        command = ["node", str(DRIVER), str(emulator()), str(image()), file.name, str(CHIP.flash - CHIP.storage), str(int(counter))]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.cycle = 0
        self.usb, self.uart, self.edges = b"", b"", []

    def close(self):
        self._process.communicate()
        os.unlink(self._image)

    def _ask(self, what, **order):
        self._process.stdin.write(json.dumps({"do": what, **order}) + "\n")
        self._process.stdin.flush()
        answer = json.loads(self._process.stdout.readline())
        assert "error" not in answer, answer["error"]
        return answer

    def run(self, us):
        """Let `us` microseconds pass."""
        answer = self._ask("run", us=us)
        self.cycle = answer["cycle"]
        self.usb += answer["usb"].encode("latin1")
        self.uart += answer["uart"].encode("latin1")
        self.edges += answer["edges"]

    @property
    def ms(self):
        return self.cycle / CYCLES_PER_US / 1000

    def send(self, data):
        self._ask("usb", data=data.decode("latin1"))

    def send_uart(self, data, baud):
        self._ask("uart", data=data.decode("latin1"), baud=baud)

    def drive(self, **levels):
        """p27=1: the world pulls GPIO27 up."""
        self._ask("pins", levels={name[1:]: level for name, level in levels.items()})

    def watch(self, pins):
        self._ask("watch", pins=list(pins))

    def until(self, text, asked=b"", most_ms=5000):
        """Run until `text` has come over USB; returns what has come so far, which is then forgotten."""
        end = self.ms + most_ms
        while text not in self.usb:
            assert self.ms < end, self.usb
            if asked:
                self.send(asked)
            self.run(SLICE_US)
        said, self.usb = self.usb, b""
        return said

    def exec(self, code, most_ms=5000):
        """Return the code's output, over the raw REPL."""
        self.send(b"\x03\x01")
        self.until(b"raw REPL; CTRL-B to exit\r\n>")
        self.send(code.encode() + b"\x04")
        said, error, _ = self.until(b"\x04>", most_ms=most_ms).removeprefix(b"OK").split(b"\x04")
        assert not error, error
        return said
