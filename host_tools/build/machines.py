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


def there(path):
    try:
        os.stat(path)
        return True
    except OSError:
        return False


def text_of(path):
    with open(path) as file:
        return file.read()


def digest(path, target=None):
    """16 hexadecimal digits of a file's bytes and of the path where it belongs, `target`; None: the file lies there."""
    found = hashlib.sha256((target or path).encode() + b"\0")
    with open(path, "rb") as file:
        while True:
            part = file.read(512)
            if not part:
                return "".join(["%02x" % byte for byte in found.digest()[:8]])
            found.update(part)


def names_chosen():
    """The names of the chosen machine and of the one before it; "" if there is none."""
    path = [path for path in (FOLDER + "/chosen", FOLDER + "/new") if there(path)]
    return (text_of(path[0]).split("\n") + ["", ""])[:2] if path else ["", ""]


def machine_names():
    """The names of the machines, in order."""
    return sorted([name for name in os.listdir(FOLDER) if there(FOLDER + "/" + name + "/modules.txt")]) if there(FOLDER) else []


def modules(name):
    """(path, digest) of a machine's files, one after another: a board has no memory for all of them."""
    with open(FOLDER + "/" + name + "/modules.txt") as file:
        for line in file:
            yield line.strip().split(" ")


in_place = {}  # digests of the firmware that runs, by path


def to_change(wanted):
    """(path, digest) of those files that are not in place."""
    for path, sum in wanted:
        if path not in in_place:
            in_place[path] = digest(path) if there(path) else None
        if in_place[path] != sum:
            yield path, sum


def missing(wanted):
    """Digests of those files that are nowhere on the board."""
    return [sum for path, sum in to_change(wanted) if not there(FILES + "/" + sum)]


def state_of(name):
    """A sentence about the fault of a machine; "" if it is whole."""
    wrong = len(missing(modules(name)))
    return "%d files of its firmware are missing or of another version: add it again" % wrong if wrong else ""


def want(text):
    """Prints the digests of files in a modules.txt that are nowhere on the board. Changes nothing on the board."""
    for sum in missing([line.split(" ") for line in text.split("\n") if line]):
        print("wants", sum)


def tidy():
    """Remove the files that no stored machine wants."""
    wanted = set([sum for name in machine_names() for _, sum in modules(name)])
    if there(FILES):
        for sum in os.listdir(FILES):
            if sum not in wanted:
                os.remove(FILES + "/" + sum)


def tell():
    names = {}
    if there("board.py"):
        exec(text_of("board.py"), names)
        print("chip", names["BOARD"]["chip"])
    print("chosen", running())
    for name in machine_names():
        print("machine %s: %s" % (name, state_of(name) or "ready"))


def move(source, target):
    if there(source):
        if there(target):
            os.remove(target)
        os.rename(source, target)


def running():
    """The name of the machine whose board file is /board.py; "before" if that belongs to none."""
    if there("board.py"):
        board = digest("board.py")
        for name in machine_names():
            if digest(FOLDER + "/" + name + "/board.py", "board.py") == board:
                return name
    return names_chosen()[0] or "before"


def duplicate(source, target):
    with open(source, "rb") as file, open(target, "wb") as made:
        while True:
            part = file.read(512)
            if not part:
                return
            made.write(part)


def note(name, last):
    """Write the names of the chosen machine and of the one before it, by a new file that replaces the old one."""
    with open(FOLDER + "/new", "w") as made:
        made.write(name + "\n" + last)
    move(FOLDER + "/new", FOLDER + "/chosen")


def make_folder(path):
    """Make the folder of a file, and those above it."""
    parts = path.split("/")[:-1]
    for count in range(len(parts)):
        folder = "/".join(parts[: count + 1])
        if not there(folder):
            os.mkdir(folder)


def put(path, sum):
    """Move the file `sum` from FILES to its path, and the file that was there to FILES."""
    make_folder(path)
    if in_place[path]:
        move(path, FILES + "/" + in_place[path])
    os.rename(FILES + "/" + sum, path)


def files_of(folder):
    """The paths of all files in a folder and those below it."""
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
        for path in [path for path in ("main.py", "stamp.txt") if there(path)] + list(files_of("passo") if there("passo") else ()):
            if path not in in_place:
                in_place[path] = digest(path)
            file.write("%s %s\n" % (path, in_place[path]))
    duplicate("board.py", FOLDER + "/before/board.py")
    move(FOLDER + "/before/new", FOLDER + "/before/modules.txt")


def retire(name, sum):
    """Keep a machine as NAME_old, if a board file of another digest is about to take its place."""
    folder = FOLDER + "/" + name
    if there(folder + "/modules.txt") and digest(folder + "/board.py", "board.py") != sum:
        make_folder(folder + OLD + "/board.py")
        for file in ("board.py", "modules.txt"):
            duplicate(folder + "/" + file, folder + OLD + "/" + file)


def remove(name):
    """Forget a stored machine, and its settings."""
    if name not in machine_names():
        raise ValueError("there is no machine " + name)
    if name == running():
        raise ValueError("machine " + name + " is the chosen one: choose another first")
    folder = FOLDER + "/" + name
    for file in ["modules.txt"] + [file for file in os.listdir(folder) if file != "modules.txt"]:
        os.remove(folder + "/" + file)
    os.rmdir(folder)


def back():
    """Choose the machine that was chosen before the one that is. A `choose` amid which the power failed is gone on with instead."""
    name = names_chosen()[1]
    if not there("board.py") and there("board.new"):
        going = digest("board.new", "board.py")
        name = [each for each in machine_names() if digest(FOLDER + "/" + each + "/board.py", "board.py") == going][0]
    if not name:
        raise ValueError("no machine was chosen before this one")
    choose(name)


def choose(name):
    """The machine `name` from the next start on. Firmware and settings of the one before are kept. While files are moved there is no
    board.py, so that a board whose power fails amid it moves nothing; the same call then goes on."""
    if name not in machine_names():
        raise ValueError("there is no machine " + name)
    wrong = state_of(name)
    if wrong:
        raise ValueError("machine " + name + ": " + wrong)
    old = running()
    now, last = names_chosen()
    if old != now:
        note(old, last)
    if old == "before" and there("board.py"):
        keep_before()
    duplicate(FOLDER + "/" + name + "/board.py", "board.new")
    if there("board.py"):
        os.remove("board.py")
    for path, sum in to_change(modules(name)):
        put(path, sum)
    if old != name:
        for file in SETTINGS:
            target = FOLDER + "/" + old + "/" + file
            make_folder(target)
            if old == name + OLD and there(file):
                duplicate(file, target)
            else:
                move(file, target)
        note(name, old)
    for file in SETTINGS:
        move(FOLDER + "/" + name + "/" + file, file)
    move("board.new", "board.py")
    print("chosen", name)
