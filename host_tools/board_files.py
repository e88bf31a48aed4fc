"""Makes, changes, takes back and removes a user's own board files, for `passo machine` and for the panel's page.

    create(Path("mine.py"), "lpt_router", {"axes.z": None})
    change_values(Path("mine.py"), {"step_program.interval_us": 250})      # keeps the text before it in mine.py.old

The firmware's check looks at each new text. If it refuses, Failure is raised with its sentence, and no file is written.
"""

import os
import re

from host_tools import board_edit, boards
from host_tools.build.machines import OLD
from host_tools.failure import Failure
from host_tools.whole_file import write_whole

TAKEN = ("before", "chosen", "files", "new")  # names in a board's folder of machines that machines.py gives itself


def check_name(name):
    """Raise Failure if a machine cannot have this name."""
    if not re.fullmatch(r"\w{1,32}", name) or name in TAKEN or name.endswith(OLD):
        raise Failure("{!r} is no name for a machine: letters, digits and _, none of {}, and no {} at its end", name, ", ".join(TAKEN), OLD)


def create(file, like, values):
    """Write the board file of a machine that is like a board of boards/, or a copy of one that is itself like another; with values
    {path: value}. Raises Failure."""
    check_name(file.stem)
    if file.exists():
        raise Failure("{} exists: passo machine set changes it", file)
    text = boards.read(boards.path(like))
    if str(like).endswith(".py") or boards.LIKE in boards.own_table(text, like):
        text = board_edit.set_values(text, {"name": file.stem})
    else:
        text = f'"""{file.stem}: like {like}, but for what stands here."""\n\nBOARD = {{\n    "name": "{file.stem}",\n    "like": "{like}",\n}}\n'
    write_whole(file, edit_text(file, text, values).encode())


def change_values(file, values):
    """Change values {path: value} of a board file. Raises Failure."""
    check_own(file)
    text = boards.read(file)
    replace_file(file, text, edit_text(file, text, values))


def go_back(file):
    """Exchange a board file and the one that it was before its last change. Raises Failure."""
    old = old_of(file)
    if not old.is_file():
        raise Failure("{} has not been changed: there is no {}", file.name, old.name)
    text = boards.read(old)
    boards.check_board(boards.parse_table(text, old), old)
    replace_file(file, boards.read(file), text)


def remove_file(file):
    """Remove a board file; its text stays in FILE.old. Raises Failure."""
    check_own(file)
    os.replace(file, old_of(file))


def edit_text(file, text, values):
    """Return the text of a board file with values {path: value} changed. Raises Failure if the firmware refuses it."""
    boards.parse_table(text, file)
    text = board_edit.set_values(text, values)
    boards.check_board(boards.parse_table(text, file), file)
    return text


def replace_file(file, before, text):
    """Write a board file; FILE.old gets the text `before`."""
    write_whole(old_of(file), before.encode())
    write_whole(file, text.encode())


def old_of(file):
    """Return the file that keeps the text before the last change."""
    return file.with_name(file.name + ".old")


def check_own(file):
    """Raise Failure if this is no board file of the user's."""
    if str(file) in boards.names() or file.resolve().parent == boards.BOARDS.resolve():
        raise Failure("{0} is one of Passo's own: passo machine new NAME --like {0}", file.stem)
    if file.suffix != ".py" or not file.is_file():
        raise Failure("{} is no board file here: passo machine new NAME --like BOARD writes one", file)


def available_files(folder):
    """Return {name: board file, as boards.load() takes it} of Passo's own, and of those in a folder whose names end in .py."""
    own = sorted(folder.glob("*.py")) if folder.is_dir() else []
    return {name: name for name in boards.names()} | {path.name: str(path) for path in own}
