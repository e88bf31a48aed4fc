"""`passo flash` as a program over each change of state of an emulated Pico, with its boot loader (boot_loader.py): stock MicroPython, Passo's
UF2, another version of it, and back. Settings, jobs and the rest of the files are on the board behind each.
"""

import os
import signal
import struct
import subprocess
from pathlib import Path

import pytest
from emulated import uf2  # noqa: F401
from test_pico_frozen import frozen  # noqa: F401

from host_tools import interpreter
from host_tools.build.frozen import CHIPS, stamp
from host_tools.build.uf2 import label_of, uf2_of
from host_tools.resources import version
from host_tools.uf2_format import BLOCK_BYTES, FLASH, PAGE

pytestmark = pytest.mark.slow
LIMIT_S = 900
OTHER = f"{version()}-0123456789ab"
KEPT = {"settings.0": b"100=250000\n", "wifi.json": b"{}", "jobs/PART": bytes(range(256)) * 20, "mine.txt": b"of the user\n"}
ASK = (
    "import os, sys\ntry:\n import passo_image\n print(passo_image.STAMP)\nexcept ImportError:\n print('stock')\n"
    "print(sorted(os.listdir()))\nfor name in {names!r}:\n print(name, open(name, 'rb').read() == {data!r}[name])"
)


class Pico:
    def __init__(self, uf2, folder, *options):
        self.drive = folder / "RPI-RP2"
        script = Path(__file__).with_name("boot_loader.py")
        self.process = subprocess.Popen([*interpreter.python(), script, uf2, self.drive, *map(str, options)], stdout=subprocess.PIPE, text=True)
        self.port = self.process.stdout.readline().strip().partition(": ")[2]
        self.environment = interpreter.environment(PASSO_BOOT_DRIVE=str(self.drive))
        self.folder = folder

    def flash(self, *options):
        return self.passo("flash", *options)

    def passo(self, *arguments):
        command = [*interpreter.passo(), *map(str, arguments), "--port", self.port]
        return subprocess.run(command, cwd=self.folder, env=self.environment, capture_output=True, text=True, timeout=LIMIT_S)

    def mpremote(self, *arguments):
        command = [*interpreter.mpremote_command(self.port), *map(str, arguments)]
        return subprocess.run(command, check=True, capture_output=True, text=True, timeout=LIMIT_S).stdout

    def bootsel(self):
        self.process.send_signal(signal.SIGUSR1)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.communicate()


def another_version(path, folder):
    """The UF2 with another stamp, as a later release has it."""
    data = path.read_bytes()
    image = bytearray()
    for at in range(0, len(data) - BLOCK_BYTES, BLOCK_BYTES):
        address, = struct.unpack_from("<I", data, at + 12)
        assert address == FLASH + len(image)
        image += data[at + 32 : at + 32 + PAGE]
    mine = stamp("rp2040").encode()
    assert mine in image
    made = uf2_of(CHIPS["rp2040"], bytes(image.replace(mine, OTHER.encode())))
    later = folder / "later.uf2"
    later.write_bytes(made.replace(f"rp2040 {stamp('rp2040')}".encode(), f"rp2040 {OTHER}".encode()))
    assert label_of(later) == ("rp2040", OTHER)
    return later


def state(pico):
    """(stamp or "stock", names in the file system); all that is to be kept is there."""
    said = pico.mpremote("exec", ASK.format(names=list(KEPT), data=KEPT)).splitlines()
    assert said[2:] == [f"{name} True" for name in KEPT], said
    return said[0], said[1]


def test_each_change_of_state(uf2, frozen, tmp_path, show):  # noqa: F811
    with Pico(uf2, tmp_path) as pico:
        done = pico.flash("--board", "two_motor_kit")
        assert done.returncode == 0 and "two_motor_kit runs on" in done.stdout, done.stderr
        for name, data in KEPT.items():
            (tmp_path / "kept").write_bytes(data)
            make = ["fs", "mkdir", "jobs", "+"] if name.startswith("jobs/") else []
            pico.mpremote(*make, "cp", tmp_path / "kept", f":{name}")
        has, names = state(pico)
        assert has == "stock" and "'passo'" in names and "'board.py'" in names
        done = pico.flash("--uf2", frozen, "--board", "two_motor_kit")
        assert done.returncode == 0 and "are kept in" in done.stdout, (done.stdout, done.stderr)
        has, names = state(pico)
        assert has == stamp("rp2040") and "'passo'" not in names and "'board.py'" in names
        later = another_version(frozen, tmp_path)
        done = pico.flash("--uf2", later, "--board", "two_motor_kit")
        assert done.returncode == 0 and "are kept in" not in done.stdout, "the file system stays where it is"
        assert f"build {OTHER}" in done.stdout and "not of this source" in done.stdout
        has, names = state(pico)
        assert has == OTHER and "'board.py'" in names
        done = pico.flash("--uf2", uf2, "--board", "two_motor_kit")
        assert done.returncode == 0 and "holds no Passo" in done.stdout and "are kept in" in done.stdout, (done.stdout, done.stderr)
        has, names = state(pico)
        assert has == "stock" and "'passo'" in names and "'board.py'" in names
    show("passo flash: stock, Passo's UF2, a later one, and back", f"{len(KEPT)} files of the user behind each")


@pytest.mark.parametrize("share", [0.3, 0.97])
def test_a_copy_of_the_uf2_that_is_cut_short(uf2, frozen, tmp_path, share):  # noqa: F811
    """The power goes while it is written: `passo flash` says what to do, and that does it."""
    blocks = len(frozen.read_bytes()) // BLOCK_BYTES
    with Pico(uf2, tmp_path, int(share * blocks)) as pico:
        done = pico.flash("--uf2", frozen, "--board", "two_motor_kit")
        assert done.returncode == 1 and "hold BOOTSEL while you plug it in, then: passo flash --uf2" in done.stderr, (done.stdout, done.stderr)
        pico.bootsel()
        while not (pico.drive_pin / "INFO_UF2.TXT").exists():
            os.sched_yield()
        done = pico.flash("--uf2", frozen, "--board", "two_motor_kit")
        assert done.returncode == 0 and "two_motor_kit runs on" in done.stdout, (done.stdout, done.stderr)
        assert pico.mpremote("exec", "import passo_image; print(passo_image.whole())").strip() == "True"


def test_machines_of_a_board_with_the_uf2(frozen, tmp_path):  # noqa: F811
    """`passo machine`: only board files are stored, and the one that is chosen runs."""
    with Pico(frozen, tmp_path) as pico:
        assert pico.flash("--board", "two_motor_kit").returncode == 0
        done = pico.passo("machine", "add", "plotter_2014")
        assert done.returncode == 0 and "plotter_2014 is stored" in done.stdout, (done.stdout, done.stderr)
        assert not (tmp_path / "build").exists()
        done = pico.passo("machine", "choose", "plotter_2014")
        assert done.returncode == 0, (done.stdout, done.stderr)
        assert "* plotter_2014" in pico.passo("machine", "list").stdout
        said = pico.mpremote("exec", "import os; from board import BOARD; print(BOARD['name'], 'passo' in os.listdir())")
        assert said.split() == ["plotter_2014", "False"]
        done = pico.passo("machine", "add", "plotter_esp32")
        assert done.returncode == 1 and "this board is an rp2040" in done.stderr


BUILD = "from board import BOARD; print(BOARD['name'], open('stamp.txt').read() == open('passo/stamp.txt').read(), open('stamp.txt').read())"


def test_machines_of_a_board_with_stock_micropython(uf2, tmp_path, show):  # noqa: F811
    """Their firmware differs: each machine's own is put in place when it is chosen, and the running one stays until then."""
    with Pico(uf2, tmp_path) as pico:
        assert pico.flash("--board", "two_motor_kit").returncode == 0
        kit = pico.mpremote("exec", BUILD).split()
        for name in ("plotter_2014", "two_motor_kit"):
            done = pico.passo("machine", "add", name)
            assert done.returncode == 0 and f"{name} is stored" in done.stdout, (done.stdout, done.stderr)
            assert pico.mpremote("exec", BUILD).split() == kit and kit[:2] == ["two_motor_kit", "True"]
        more = int(pico.mpremote("exec", "import os; print(sum([os.stat('machines/files/' + name)[6] for name in os.listdir('machines/files')]))"))
        stamps = {}
        for name in ("plotter_2014", "two_motor_kit", "plotter_2014"):
            done = pico.passo("machine", "choose", name)
            assert done.returncode == 0, (done.stdout, done.stderr)
            chosen, whole, mark = pico.mpremote("exec", BUILD).split()
            assert chosen == name and whole == "True" and stamps.setdefault(name, mark) == mark
        assert stamps["two_motor_kit"] == kit[2] != stamps["plotter_2014"]
        listed = pico.passo("machine", "list").stdout
        assert "* plotter_2014" in listed and listed.count("ready") == 2, listed
    show("a second machine on stock MicroPython", f"{more} bytes of files that differ")
