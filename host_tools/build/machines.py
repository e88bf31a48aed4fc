"""Runs on the board: keeps the board files, firmware and settings of several machines, of which one is chosen.

    machines/NAME/board.py      the board file
    machines/NAME/modules.txt   `path digest` of each file of the firmware that it needs
    machines/NAME/settings.0 .1 its saved settings, while another machine is chosen
    machines/files/DIGEST       a file of firmware that a machine wants, while another of that path is in place
    machines/chosen             the name of the one whose board file is /board.py, and that of the one that was chosen before it

NAME_old is what NAME was before its board file was last changed; both start with the settings of then. `before` is what ran before any machine
was chosen.

`passo machine` sends this text with a call behind it. It reads the printed lines: `chip …`, `chosen …`, `machine NAME: state`, `wants DIGEST`.
"""

import hashlib
import os

FOLDER = "machines"
SETTINGS = ("settings.0", "settings.1")
OLD = "_old"
FILES = FOLDER + "/files"


def exists(path):
    """True if there is a file or folder."""
    try:
        os.stat(path)
        return True
    except OSError:
        return False


def read_text(path):
    """Return a file's text."""
    with open(path) as file:
        return file.read()


def file_digest(path, target=None):
    """Return 16 hexadecimal digits of the hash of a file's bytes and of the path where it belongs, `target`; None: the file lies there."""
    found = hashlib.sha256((target or path).encode() + b"\0")
    with open(path, "rb") as file:
        while True:
            part = file.read(512)
            if not part:
                return "".join(["%02x" % byte for byte in found.digest()[:8]])
            found.update(part)


def names_chosen():
    """Return the names of the chosen machine and of the one before it; "" if there is none."""
    path = [path for path in (FOLDER + "/chosen", FOLDER + "/new") if exists(path)]
    return (read_text(path[0]).split("\n") + ["", ""])[:2] if path else ["", ""]


def machine_names():
    """Return the names of the machines, in order."""
    return sorted([name for name in os.listdir(FOLDER) if exists(FOLDER + "/" + name + "/modules.txt")]) if exists(FOLDER) else []


def modules_of(name):
    """Yield (path, digest) of a machine's files: a board has no memory for all of them."""
    with open(FOLDER + "/" + name + "/modules.txt") as file:
        for line in file:
            yield line.strip().split(" ")


in_place = {}  # digests of the firmware that runs, by path


def to_change(wanted):
    """Yield (path, digest) of those files that are not in place."""
    for path, sum in wanted:
        if path not in in_place:
            in_place[path] = file_digest(path) if exists(path) else None
        if in_place[path] != sum:
            yield path, sum


def digests_missing(wanted):
    """Return the digests of those files that are nowhere on the board."""
    return [sum for path, sum in to_change(wanted) if not exists(FILES + "/" + sum)]


def state_of(name):
    """Return a sentence about the fault of a machine; "" if it is whole."""
    wrong = len(digests_missing(modules_of(name)))
    return "%d files of its firmware are missing or of another version: add it again" % wrong if wrong else ""


def print_missing(text):
    """Print the digests of files in a modules.txt that are nowhere on the board. Changes nothing on the board."""
    for sum in digests_missing([line.split(" ") for line in text.split("\n") if line]):
        print("wants", sum)


def remove_unused():
    """Remove the files that no stored machine wants."""
    wanted = set([sum for name in machine_names() for _, sum in modules_of(name)])
    if exists(FILES):
        for sum in os.listdir(FILES):
            if sum not in wanted:
                os.remove(FILES + "/" + sum)


def print_machines():
    """Print the board's chip, the chosen machine, and the state of each machine."""
    names = {}
    if exists("board.py"):
        exec(read_text("board.py"), names)
        print("chip", names["BOARD"]["chip"])
    print("chosen", running_name())
    for name in machine_names():
        print("machine %s: %s" % (name, state_of(name) or "ready"))


def move_file(source, target):
    """Move a file, if it is there, in the place of another."""
    if exists(source):
        if exists(target):
            os.remove(target)
        os.rename(source, target)


def running_name():
    """Return the name of the machine whose board file is /board.py; "before" if that belongs to none."""
    if exists("board.py"):
        board = file_digest("board.py")
        for name in machine_names():
            if file_digest(FOLDER + "/" + name + "/board.py", "board.py") == board:
                return name
    return names_chosen()[0] or "before"


def copy_file(source, target):
    """Copy a file, 512 bytes at a time."""
    with open(source, "rb") as file, open(target, "wb") as made:
        while True:
            part = file.read(512)
            if not part:
                return
            made.write(part)


def write_chosen(name, last):
    """Write the names of the chosen machine and of the one before it, by a new file that replaces the old one."""
    with open(FOLDER + "/new", "w") as made:
        made.write(name + "\n" + last)
    move_file(FOLDER + "/new", FOLDER + "/chosen")


def make_folder(path):
    """Make the folder of a file, and those above it."""
    parts = path.split("/")[:-1]
    for count in range(len(parts)):
        folder = "/".join(parts[: count + 1])
        if not exists(folder):
            os.mkdir(folder)


def swap_file(path, sum):
    """Move the file `sum` from FILES to its path, and the file that was there to FILES."""
    make_folder(path)
    if in_place[path]:
        move_file(path, FILES + "/" + in_place[path])
    os.rename(FILES + "/" + sum, path)


def files_of(folder):
    """Yield the paths of all files in a folder and those below it."""
    for name in sorted(os.listdir(folder)):
        path = folder + "/" + name
        if os.stat(path)[0] & 0x4000:
            for each in files_of(path):
                yield each
        else:
            yield path


def keep_before():
    """Store what runs now, which is no machine that was added, as the machine `before`."""
    make_folder(FOLDER + "/before/modules.txt")
    with open(FOLDER + "/before/new", "w") as file:
        for path in [path for path in ("main.py", "stamp.txt") if exists(path)] + list(files_of("passo") if exists("passo") else ()):
            if path not in in_place:
                in_place[path] = file_digest(path)
            file.write("%s %s\n" % (path, in_place[path]))
    copy_file("board.py", FOLDER + "/before/board.py")
    move_file(FOLDER + "/before/new", FOLDER + "/before/modules.txt")


def keep_old(name, sum):
    """Keep a machine as NAME_old, if a board file of another digest is about to take its place."""
    folder = FOLDER + "/" + name
    if exists(folder + "/modules.txt") and file_digest(folder + "/board.py", "board.py") != sum:
        make_folder(folder + OLD + "/board.py")
        for file in ("board.py", "modules.txt"):
            copy_file(folder + "/" + file, folder + OLD + "/" + file)


def remove_machine(name):
    """Remove a stored machine, and its settings. Raises ValueError if it is the chosen one, or there is none."""
    if name not in machine_names():
        raise ValueError("there is no machine " + name)
    if name == running_name():
        raise ValueError("machine " + name + " is the chosen one: choose another first")
    folder = FOLDER + "/" + name
    for file in ["modules.txt"] + [file for file in os.listdir(folder) if file != "modules.txt"]:
        os.remove(folder + "/" + file)
    os.rmdir(folder)


def choose_last():
    """Choose the machine that was chosen before the one that is. If the power failed amid choose_machine(), go on with that instead. Raises
    ValueError."""
    name = names_chosen()[1]
    if not exists("board.py") and exists("board.new"):
        going = file_digest("board.new", "board.py")
        name = [each for each in machine_names() if file_digest(FOLDER + "/" + each + "/board.py", "board.py") == going][0]
    if not name:
        raise ValueError("no machine was chosen before this one")
    choose_machine(name)


def choose_machine(name):
    """Start as the machine `name` from the next start on. Firmware and settings of the one before are kept. While files are moved there is no
    board.py, so that a board whose power fails amid it moves nothing; the same call then goes on. Raises ValueError."""
    if name not in machine_names():
        raise ValueError("there is no machine " + name)
    wrong = state_of(name)
    if wrong:
        raise ValueError("machine " + name + ": " + wrong)
    old = running_name()
    now, last = names_chosen()
    if old != now:
        write_chosen(old, last)
    if old == "before" and exists("board.py"):
        keep_before()
    copy_file(FOLDER + "/" + name + "/board.py", "board.new")
    if exists("board.py"):
        os.remove("board.py")
    for path, sum in to_change(modules_of(name)):
        swap_file(path, sum)
    if old != name:
        for file in SETTINGS:
            target = FOLDER + "/" + old + "/" + file
            make_folder(target)
            if old == name + OLD and exists(file):
                copy_file(file, target)
            else:
                move_file(file, target)
        write_chosen(name, old)
    for file in SETTINGS:
        move_file(FOLDER + "/" + name + "/" + file, file)
    move_file("board.new", "board.py")
    print("chosen", name)
