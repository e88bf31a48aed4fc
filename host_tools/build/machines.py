"""Runs on the board: keeps the board files and settings of several machines, of which one is chosen.

    machines/NAME/board.py      the board file
    machines/NAME/modules.txt   `path sha256` of each file of the firmware that it needs
    machines/NAME/settings.0 .1 its saved settings, while another machine is chosen
    machines/chosen             the name of the one whose board file is /board.py

`passo machine` sends this text with a call behind it. What is printed is for it: `chip …`, `chosen …`, `machine NAME: state`.
"""

import hashlib
import os

FOLDER = "machines"
SETTINGS = ("settings.0", "settings.1")


def there(path):
    try:
        os.stat(path)
        return True
    except OSError:
        return False


def text_of(path):
    with open(path) as file:
        return file.read()


def digest(path):
    found = hashlib.sha256()
    with open(path, "rb") as file:
        while True:
            part = file.read(512)
            if not part:
                return "".join(["%02x" % byte for byte in found.digest()[:8]])
            found.update(part)


def chosen():
    path = FOLDER + "/chosen"
    return text_of(path).strip() if there(path) else ""


def state_of(name):
    """What is wrong with a machine: "" if nothing is."""
    changed = 0
    for line in text_of(FOLDER + "/" + name + "/modules.txt").split("\n"):
        if line:
            path, wanted = line.split(" ")
            if not there(path) or digest(path) != wanted:
                changed += 1
    return "%d files of its firmware are missing or of another version: add it again" % changed if changed else ""


def tell():
    names = {}
    if there("board.py"):
        exec(text_of("board.py"), names)
        print("chip", names["BOARD"]["chip"])
    print("chosen", chosen())
    if there(FOLDER):
        for name in sorted(os.listdir(FOLDER)):
            if there(FOLDER + "/" + name + "/modules.txt"):
                print("machine %s: %s" % (name, state_of(name) or "ready"))


def move(source, target):
    if there(source):
        if there(target):
            os.remove(target)
        os.rename(source, target)


def choose(name):
    """The machine `name` from the next start on. Settings stay with the machine they were made for."""
    if not there(FOLDER + "/" + name + "/modules.txt"):
        raise ValueError("there is no machine " + name)
    wrong = state_of(name)
    if wrong:
        raise ValueError("machine " + name + ": " + wrong)
    old = chosen()
    if old != name:
        home = FOLDER + "/" + (old or "before")
        if not there(home):
            os.mkdir(home)
        for file in SETTINGS:
            move(file, home + "/" + file)
    with open("board.new", "w") as file:
        file.write(text_of(FOLDER + "/" + name + "/board.py"))
    move("board.new", "board.py")
    with open(FOLDER + "/chosen", "w") as file:
        file.write(name)
    for file in SETTINGS:
        move(FOLDER + "/" + name + "/" + file, file)
    print("chosen", name)
