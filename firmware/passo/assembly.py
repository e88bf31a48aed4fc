"""What the app needs only while it puts a board file's machine together: drive, speeds and languages.

A board forgets it when that is done: it has better uses for the memory.
"""

import sys

from passo.control.board_error import BoardError
from passo.control.settings import SPEED, STEPS
from passo.steps.word import TICKS_PER_S, Layout, us_to_ticks

PROTOCOLS = ("plotter", "grbl", "pulses", "torch", "keys")
STREAMED = ("grbl",)  # lines and arcs as they come: program and tools are loaded for them
STORED = ("plotter",)  # objects that are stored, then drawn


def _named(board, languages):
    return bool([link for link in board["links"] if link["protocol"] in languages])


def streamed(board):
    """True where some link's language asks for motion as it comes."""
    return _named(board, STREAMED)


def stored(board):
    """True where some link's language asks for stored objects."""
    return _named(board, STORED)


def languages(board):
    """The modules of the languages of the board file's links: language.opened(link, board, controller, shared) is a
    protocol. Only what is named is loaded, and early: machine code wants memory in one piece. Raises BoardError."""
    modules = []
    for link in board["links"]:
        name = link["protocol"]
        if name not in PROTOCOLS:
            raise BoardError("link %s: unknown protocol %r; known are %s" % (link["name"], name, ", ".join(PROTOCOLS)))
        try:
            modules.append(__import__("passo.languages." + name, None, None, ("opened",)))
        except ImportError as missing:
            raise BoardError("link %s: %s is not on this board (%s): flash it anew" % (link["name"], name, missing))
    return modules


def changeover(board, controller, shared):
    """Where the board file names relays between two controllers, motion of any language minds them."""
    if [item for item in board["outputs"] if item["role"] != "none"]:
        from passo.control.changeover import Changeover

        shared["changeover"] = Changeover(board, controller)


def make_drive(board):
    """(layout, drive, levels without current) of the board's motors; drive is None where the step form will do."""
    kind = board["drive"]["kind"]
    names = [axis["name"] for axis in board["axes"]]
    count = len(names)
    if kind == "step_dir":
        from passo.drives import step_dir

        return Layout(kind, count, 2 * count, step_dir.pin_names(names), (1 << count) - 1), None, 0
    from passo.drives.coils import CoilDrive

    if kind == "unipolar":
        from passo.drives import unipolar as motors
    else:
        from passo.drives import pbl3770a as motors
    mode = board["drive"]["mode"]
    backwards = 0
    for axis in range(count):
        backwards |= board["axes"][axis]["reversed"] << axis
    hold = motors.HOLD[mode] if kind == "pbl3770a" else None
    drive = CoilDrive(count, motors.MODES[mode], motors.WIDTH, hold, backwards, motors.OFF)
    pins = [name + "_" + pin for name in names for pin in motors.PINS]
    off = 0
    for axis in range(count):
        off |= motors.OFF << axis * motors.WIDTH
    return Layout("coils", count, count * motors.WIDTH, pins, 0), drive, off


def forget(name):
    """Give back the memory of a module of control that made what it was to make; asked for again it is loaded again."""
    from passo import control

    if sys.modules.pop("passo.control." + name, None):
        delattr(control, name)


def fastest(board, settings):
    """Steps a second of the fastest axis."""
    speed = board["speed"]
    most = 500_000 // speed["min"] if speed["unit"] == "half_period_us" else speed["max"]
    for axis in range(len(board["axes"])):
        most = max(most, settings.value(STEPS + axis) * settings.value(SPEED + axis) // 60_000_000)
    return most


def check_speed(board, least):
    """Every speed the board file allows must leave the player its shortest word, `least` ticks. Raises BoardError."""
    speed = board["speed"]
    ticks = us_to_ticks(2 * speed["min"]) if speed["unit"] == "half_period_us" else TICKS_PER_S // speed["max"]
    if ticks < least:
        raise BoardError("speed: steps every %d ticks of 80 ns; the drive needs %d" % (ticks, least))
