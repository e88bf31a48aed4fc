"""Finding and loading board files.

    board = load("plotter_2014")            # boards/plotter_2014.py
    board = load("~/mine/router.py")        # any file with BOARD = {...}

What is wrong with a file is a Failure; its values are checked by the firmware (passo.config.boardfile).
"""

import copy
import runpy
from pathlib import Path

from host_tools.failure import Failure, reason
from host_tools.resources import BOARDS
from passo.config.boardfile import BoardError, check
from passo.config.spi_drivers_keys import NO_STALL


def names():
    """Names of the project's boards, in alphabetical order."""
    return sorted(path.stem for path in BOARDS.glob("*.py") if not path.stem.startswith("_"))


def path(name):
    """The file of a board given by its name or by the path of a .py file. Raises Failure if there is none."""
    if str(name).endswith(".py"):
        found = Path(name).expanduser()
        if not found.is_file():
            raise Failure("no board file {}", name)
        return found
    if name not in names():
        raise Failure("unknown board {!r}; known are {}, or give the path of a .py file", name, ", ".join(names()))
    return BOARDS / f"{name}.py"


def load(name):
    """The BOARD dict of a board given by name or path, as it stands there. Raises Failure with what was wrong with the file."""
    found = path(name)
    try:
        module = runpy.run_path(str(found))
    except (Exception, SystemExit) as error:
        raise Failure("board file {} cannot be read: {}", found, error) from error
    board = module.get("BOARD")
    if not isinstance(board, dict):
        raise Failure("board file {} has no BOARD = {{...}}", found)
    try:
        check(copy.deepcopy(board))
    except BoardError as error:
        raise Failure("board {}: {}", name, reason(error)) from error
    except (TypeError, ValueError) as error:
        raise Failure("board file {} cannot be read: {}", found, error) from error
    return board


def stalling(board):
    """The board file's key, `drivers` or `spi_drivers`, of drivers by whose stall an axis homes; None if no axis does."""
    for key, none in (("drivers", 0), ("spi_drivers", NO_STALL)):
        if any(motor.get("stall", none) != none for motor in (board.get(key) or {}).get("motors", ())):
            return key
    return None


def steps_per_mm(board):
    """Steps per millimetre of X and Y, as floats."""
    x_axis, y_axis = board["axes"][0], board["axes"][1]
    return x_axis["steps_per_m"] / 1000, y_axis["steps_per_m"] / 1000


def travel_steps(board):
    """The largest coordinate of X and Y in steps; the smallest is 0."""
    return board["axes"][0]["travel_steps"], board["axes"][1]["travel_steps"]
