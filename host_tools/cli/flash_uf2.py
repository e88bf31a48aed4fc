"""UF2s of `passo flash`: it asks the board which one it runs, and puts another one there by the chip's own boot loader.

    has = parse_answer(text, port)  # what ask_command(port) prints; has.chip is None: MicroPython without Passo
    replace_uf2(port, path, has)    # the board starts with the UF2 of a file; files survive

The boot loader shows the board as a drive: INFO_UF2.TXT on it says which chip it is. On Linux the desktop mounts it, or udisksctl;
on Windows it gets a letter.
"""

import os
import shutil
import subprocess
import tempfile
import time
from collections import namedtuple
from pathlib import Path

from host_tools import interpreter
from host_tools.build.frozen import CHIPS
from host_tools.build.uf2 import label_of
from host_tools.emulator.filesystem import location_of
from host_tools.failure import Failure
from host_tools.language import _
from host_tools.resources import HOST_TOOLS
from host_tools.uf2_format import is_whole

ASK = HOST_TOOLS / "build" / "ask_board.py"
REMOVE_PACKAGE = HOST_TOOLS / "build" / "remove_package.py"
DRIVES = "RPI-RP2", "RP2350"  # names of the drives that the chips' boot loaders show
INFO = "INFO_UF2.TXT"
DRIVE_S, START_S, COPY_S = 20, 30, 600
_OF_PACKAGE = "passo", "main.py", "stamp.txt", "source.txt"  # not carried over: another build brings its own
# `chip`: of Passo's UF2, None of another interpreter; `files_at`: where its file system begins, −1 unknown.
Has = namedtuple("Has", "chip stamp version files_at names")


def mpremote_command(port):
    """Return the command that runs mpremote with the board on `port`."""
    return interpreter.mpremote_command(port)


def ask_command(port):
    """Return the command that asks a board which interpreter it runs: parse_answer() reads its output."""
    return [*mpremote_command(port), "run", str(ASK)]


def parse_answer(text, port):
    """Return the Has of ask_board.py's output. Raises Failure if the board runs something other than MicroPython."""
    lines = text.splitlines()
    words = lines[0].split() if lines else []
    if len(lines) < 2 or words[0] not in ("uf2", "micropython"):
        raise Failure("{} runs {}, and no MicroPython: docs/inside/build.md says how a UF2 comes onto a board", port, " ".join(words) or _("nothing that answers"))
    chip, stamp, version = words[1:4] if words[0] == "uf2" else (None, None, words[1])
    return Has(chip, stamp, version, int(lines[1]), lines[2].split() if len(lines) > 2 else [])


def check_fits(has, board, name):
    """Raise Failure if the UF2 that a board has does not serve a board file, a dict."""
    chip = CHIPS.get(has.chip)
    if chip is None or chip.mcu != board["chip"] or board.get("network") and not chip.network:
        wanted = board["chip"] + ("_w" if board.get("network") else "")
        raise Failure("the board has Passo's UF2 for the {}, and {} wants that for the {}: passo flash --uf2 FILE", has.chip, name, wanted)


def copy_command(port, board_file):
    """Return the command that lays a board file beside Passo's UF2, and resets."""
    return [*mpremote_command(port), "run", str(REMOVE_PACKAGE), "+", "cp", str(board_file), ":board.py", "+", "reset"]


# --- another UF2


def replace_uf2(port, path, has):
    """Write another UF2 by the chip's boot loader; the board's files survive. `has`: of the board; None if nothing answers, which then has to be in
    its boot loader. Takes up to some minutes. Raises Failure."""
    kept = save_files(port, path, has) if has else None
    if has:
        subprocess.run([*mpremote_command(port), "exec", "--no-follow", "import machine; machine.bootloader()"], capture_output=True, timeout=START_S)
    drive = wait_for(find_drive, DRIVE_S)
    if drive is None:
        raise start_failure(path, kept)
    print(_("copying {} to {}", path.name, drive))
    write(path, drive)
    if wait_for(lambda: find_drive() is None, DRIVE_S) is None or wait_for(lambda: board_answers(port), START_S) is None:
        raise start_failure(path, kept)
    if kept:
        put_back(port, kept)


def start_failure(path, kept=None):
    """Return the Failure of a board that did not start with the UF2; print where its files are, if they were saved in `kept`."""
    if kept:
        print(_("the board's files are in {0}; once it answers: mpremote cp -r {0}/* :", kept))
    return Failure("the board did not start with {0}: hold BOOTSEL while you plug it in, then: passo flash --uf2 {0}", path)


def save_files(port, path, has):
    """Return a folder with the board's files if they would be lost, because the file system begins elsewhere; else None. Raises Failure if one cannot
    be read."""
    if has.files_at == location_of(path)[0]:
        return None
    folder = Path(tempfile.mkdtemp(prefix="passo-files-"))
    names = [name for name in has.names if name not in _OF_PACKAGE]
    for name in names:
        done = subprocess.run([*mpremote_command(port), "cp", "-r", f":{name}", str(folder)], capture_output=True, text=True, timeout=COPY_S)
        if done.returncode:
            raise Failure("{} cannot be read from the board, and its file system is to move: {}", name, done.stderr.strip())
    print(_("the file system begins elsewhere: {} files and folders are kept in {}", len(names), folder))
    return folder


def put_back(port, folder):
    """Copy the files in `folder` to the board, and remove the folder. Raises Failure; the folder stays then."""
    names = sorted(str(each) for each in folder.iterdir())
    if names:
        done = subprocess.run([*mpremote_command(port), "cp", "-r", *names, ":"], capture_output=True, text=True, timeout=COPY_S)
        if done.returncode:
            raise Failure("the board's files could not be put back, and are in {}: {}", folder, done.stderr.strip())
    shutil.rmtree(folder)


def write(path, drive):
    """Write the UF2 to the boot loader's drive. The board restarts when the last block has come: some systems report that as an error, which is
    ignored."""
    data = path.read_bytes()
    try:
        with open(drive / path.name, "wb") as target:
            target.write(data)
            target.flush()
            os.fsync(target.fileno())
    except OSError:
        pass  # replace_uf2() finds out by waiting for the board to start


def wait_for(question, limit_s):
    """Call question() each 0.2 s; return its first result that is true, or None after `limit_s`."""
    end = time.monotonic() + limit_s
    while time.monotonic() < end:
        found = question()
        if found:
            return found
        time.sleep(0.2)
    return None


def board_answers(port):
    """True if MicroPython answers on the port within 30 s."""
    try:
        return subprocess.run([*mpremote_command(port), "exec", "pass"], capture_output=True, timeout=START_S).returncode == 0
    except subprocess.TimeoutExpired:
        return False


def find_drive():
    """Return the folder of the boot loader's drive, or None; on Linux mount it by udisksctl if it is there. PASSO_BOOT_DRIVE names a drive mounted
    elsewhere."""
    if named := os.environ.get("PASSO_BOOT_DRIVE"):
        return Path(named) if (Path(named) / INFO).is_file() else None
    if os.name == "nt":
        places = [Path(f"{letter}:/") for letter in "DEFGHIJKLMNOPQRSTUVWXYZ"]
    else:
        user = os.environ.get("USER", "root")
        roots = [Path("/Volumes"), Path("/media"), Path("/run/media") / user, Path("/media") / user, Path("/mnt")]
        places = [root / name for root in roots for name in DRIVES]
    for place in places:
        if (place / INFO).is_file():
            return place
    for name in DRIVES:
        disk = Path("/dev/disk/by-label") / name
        if disk.exists() and shutil.which("udisksctl"):
            subprocess.run(["udisksctl", "mount", "--no-user-interaction", "-b", str(disk)], capture_output=True)
    return None


def check_file(path):
    """Return the label of a UF2 as label_of() has it; None is plain MicroPython. Raises Failure if the file is missing or not whole."""
    if not path.is_file():
        raise Failure("no file {}", path)
    if not is_whole(path.read_bytes()):
        raise Failure("{} is no whole UF2", path)
    return label_of(path)
