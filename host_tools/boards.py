"""Finding and loading board files.

    board = load("plotter_2014")            # boards/plotter_2014.py
    board = load("~/mine/router.py")        # any file with BOARD = {...}

A board file is data, though it is written in Python: it is read here, and nowhere else on a PC, and never executed.
What is wrong with a file is a Failure; its values are checked by the firmware (passo.config.boardfile).
"""

import ast
import copy
import tokenize
import warnings
from pathlib import Path

from passo.config.boardfile import BoardError, check

from host_tools.failure import Failure, reason
from host_tools.language import line_text
from host_tools.resources import BOARDS


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
        with tokenize.open(found) as file:
            text = file.read()
    except (SyntaxError, ValueError, OSError) as error:
        raise Failure("board file {} cannot be read: {}", found, _why(error)) from error
    board = table(text, found)
    try:
        check(copy.deepcopy(board))
    except BoardError as error:
        raise Failure("board {}: {}", name, reason(error)) from error
    except (TypeError, ValueError) as error:
        raise Failure("board file {} cannot be read: {}", found, error) from error
    return board


def table(text, found):
    """The BOARD dict of a board file's text; `found`: where it stands. Raises Failure, with the line of what is more than data."""
    try:
        with warnings.catch_warnings(action="ignore"):  # a backslash that means nothing, in a comment of several lines
            statements = ast.parse(text).body
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise Failure("board file {} cannot be read: {}", found, _why(error)) from error
    board = None
    for statement in statements:
        if isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant):
            continue  # what the file says of itself
        try:
            board = _value(statement)
        except (ValueError, TypeError, RecursionError, MemoryError):
            line = _first_line_of_code(statement)
            raise Failure("board file {}, line {}: this is code; a board file holds BOARD = {{...}} of plain values, and comments", found, line) from None
    if not isinstance(board, dict):
        raise Failure("board file {} has no BOARD = {{...}}", found)
    return board


def _value(statement):
    """What `BOARD = …` says. Raises ValueError or another error if it is another statement, or more than plain values."""
    if not _assigns_board(statement):
        raise ValueError
    return ast.literal_eval(statement.value)


def _assigns_board(statement):
    return isinstance(statement, ast.Assign) and [getattr(target, "id", "") for target in statement.targets] == ["BOARD"]


def _first_line_of_code(statement):
    """The line of the first part of a statement that is no plain value; its own if all of them are."""
    waiting = [statement.value] if _assigns_board(statement) else []
    while waiting:
        node = waiting.pop()
        if not isinstance(node, (ast.Dict, ast.List, ast.Tuple, ast.Set, ast.Constant, ast.UnaryOp)):
            return node.lineno
        waiting += reversed([each for each in ast.iter_child_nodes(node) if isinstance(each, ast.expr)])
    return statement.lineno


def _why(error):
    """Why a text is no Python, in the interpreter's words and with the line."""
    if isinstance(error, SyntaxError) and error.lineno:
        return f"{error.msg} ({line_text(error.lineno)})"
    return reason(error) if str(error) else type(error).__name__


def steps_per_mm(board):
    """Steps per millimetre of X and Y, as floats."""
    x_axis, y_axis = board["axes"][0], board["axes"][1]
    return x_axis["steps_per_m"] / 1000, y_axis["steps_per_m"] / 1000


def travel_steps(board):
    """The largest coordinate of X and Y in steps; the smallest is 0."""
    return board["axes"][0]["travel_steps"], board["axes"][1]["travel_steps"]
