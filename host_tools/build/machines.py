"""Runs on the board: keeps the board files, firmware and settings of several machines, of which one is chosen.

    machines/NAME/board.py      the board file
    machines/NAME/modules.txt   `path digest` of each file of the firmware that it needs
    machines/NAME/settings.0 .1 its saved settings, while another machine is chosen
    machines/files/DIGEST       a file of firmware that a machine wants, while another of that path is in place
    machines/chosen             the name of the one whose board file is /board.py

`passo machine` sends this text with a call behind it. What is printed is for it: `chip …`, `chosen …`, `machine NAME: state`, `wants DIGEST`.
"""

import hashlib
import os

FOLDER = "machines"
SETTINGS = ("settings.0", "settings.1")
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


def chosen():
    path = FOLDER + "/chosen"
    return text_of(path).strip() if there(path) else ""


def stored():
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
    """What is wrong with a machine: "" if nothing is."""
    wrong = len(missing(modules(name)))
    return "%d files of its firmware are missing or of another version: add it again" % wrong if wrong else ""


def want(text):
    """Asks for the files that are nowhere on the board, for a modules.txt. Nothing is changed: what runs goes on as it is."""
    for sum in missing([line.split(" ") for line in text.split("\n") if line]):
        print("wants", sum)


def tidy():
    """Remove the files that no stored machine wants."""
    wanted = set([sum for name in stored() for _, sum in modules(name)])
    if there(FILES):
        for sum in os.listdir(FILES):
            if sum not in wanted:
                os.remove(FILES + "/" + sum)


def tell():
    names = {}
    if there("board.py"):
        exec(text_of("board.py"), names)
        print("chip", names["BOARD"]["chip"])
    print("chosen", chosen())
    for name in stored():
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
        for name in stored():
            if digest(FOLDER + "/" + name + "/board.py", "board.py") == board:
                return name
    return chosen() or "before"


def duplicate(source, target):
    with open(source, "rb") as file, open(target, "wb") as made:
        while True:
            part = file.read(512)
            if not part:
                return
            made.write(part)


def note(name):
    with open(FOLDER + "/chosen.new", "w") as file:
        file.write(name)
    move(FOLDER + "/chosen.new", FOLDER + "/chosen")


def make_folder(path):
    """The folder of a file, and those above it."""
    parts = path.split("/")[:-1]
    for count in range(len(parts)):
        folder = "/".join(parts[: count + 1])
        if not there(folder):
            os.mkdir(folder)


def put(path, sum):
    """The file `sum` of FILES to its place; what was there is kept in FILES."""
    make_folder(path)
    if in_place[path]:
        move(path, FILES + "/" + in_place[path])
    os.rename(FILES + "/" + sum, path)


def choose(name):
    """The machine `name` from the next start on. Firmware and settings of the one before are kept. While files are moved there is no
    board.py, so that a board whose power fails amid it moves nothing; the same call then goes on."""
    if name not in stored():
        raise ValueError("there is no machine " + name)
    wrong = state_of(name)
    if wrong:
        raise ValueError("machine " + name + ": " + wrong)
    old = running()
    if old != chosen():
        note(old)
    duplicate(FOLDER + "/" + name + "/board.py", "board.new")
    if there("board.py"):
        os.remove("board.py")
    for path, sum in to_change(modules(name)):
        put(path, sum)
    if old != name:
        for file in SETTINGS:
            target = FOLDER + "/" + old + "/" + file
            make_folder(target)
            move(file, target)
        note(name)
    for file in SETTINGS:
        move(FOLDER + "/" + name + "/" + file, file)
    move("board.new", "board.py")
    print("chosen", name)
