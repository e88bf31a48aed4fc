"""Finding and loading board files.

    board = load("plotter_2014")            # boards/plotter_2014.py
    board = load("~/mine/router.py")        # any file with BOARD = {...}
    data = board_py("router_4axis")         # the board's board.py: the file, or the whole of one that is like another

A file with `"like": "router_3axis"` has only its differences from that file of boards/: see merge_changes(). Boards, builds and everything behind
load() get the whole.

A board file is data, though it is written in Python: it is read here, and nowhere else on a PC, and never executed.
Faults of a file are a Failure; the firmware checks its values (passo.config.boardfile).
"""

import ast
import copy
import importlib
import json
import tokenize
import warnings
from pathlib import Path

from passo.config.boardfile import BoardError, check
from passo.machine_builder import check_speed
from passo.steps.wiring import word_times
from passo.steps.word import TICKS_PER_S

from host_tools.failure import Failure, reason
from host_tools.language import line_text
from host_tools.resources import BOARDS

LIKE = "like"


def names():
    """Return the names of the project's boards, in alphabetical order."""
    return sorted(path.stem for path in BOARDS.glob("*.py") if not path.stem.startswith("_"))


def path(name):
    """Return the file of a board given by its name or by the path of a .py file. Raises Failure if there is none."""
    if str(name).endswith(".py"):
        found = Path(name).expanduser()
        if not found.is_file():
            raise Failure("no board file {}", name)
        return found
    if name not in names():
        raise Failure("unknown board {!r}; known are {}, or give the path of a .py file", name, ", ".join(names()))
    return BOARDS / f"{name}.py"


def load(name):
    """Return the BOARD dict of a board given by name or path, as it stands there. Raises Failure if the file is wrong."""
    found = path(name)
    return check_board(parse_table(read(found), found), name)


def check_board(board, name):
    """Return `board`, a dict, if the firmware takes it. Raises Failure, with `name`, if it does not."""
    try:
        _check_speeds(check(copy.deepcopy(board)))
    except BoardError as error:
        raise Failure("board {}: {}", name, reason(error)) from error
    except (TypeError, ValueError) as error:
        raise Failure("board file {} cannot be read: {}", name, error) from error
    return board


def _check_speeds(board):
    """Raise BoardError if speeds of a checked board leave its drive's pulses no time: those of `speed`, with which no board would start, and those
    of each axis, which would come out as STEP pulses too short."""
    least = word_times(board)[1]
    check_speed(board, least)
    if board["drive"]["kind"] != "step_dir":
        return  # coils have no pulses
    for axis in board["axes"]:
        steps_s = axis["steps_per_m"] * axis["max_mm_min"] // 60_000
        if steps_s > TICKS_PER_S // least:
            raise BoardError("axis %s: %d steps/m at %d mm/min make %d steps/s; pulses of this drive leave room for %d"
                % (axis["name"], axis["steps_per_m"], axis["max_mm_min"], steps_s, TICKS_PER_S // least))  # fmt: skip


def board_py(name):
    """Return the bytes of board.py for a board given by name or path. Raises Failure."""
    found = path(name)
    text = read(found)
    own = own_table(text, found)
    if LIKE not in own:
        return found.read_bytes()
    head = f"# The whole of {found.name}, which is like {own[LIKE]}: change that file, not this one.\n"
    return (head + text_of(merge_into_base(own, found))).encode()


def settings_of(board):
    """Return the settings of a board that was checked, its languages' and options' too: {number: (name, decimals, default, least, most)}."""
    from passo.config import setting_numbers

    found = setting_numbers.make(board)
    for link in board["links"]:
        language = importlib.import_module("passo.protocols." + link["protocol"])
        if hasattr(language, "settings"):
            language.settings(board, found)
    return {**found, **getattr(board.get("additions"), "settings", {})}


def text_of(board):
    """Return the text of a board file that has these values."""
    return f"BOARD = {text_of_value(board, 0)}\n"


def names_like(base):
    """Return the names of the project's boards that say "like": `base`."""
    return [name for name in names() if own_table(read(path(name)), path(name)).get(LIKE) == base]


def read(found):
    """Return the text of a board file. Raises Failure."""
    try:
        with tokenize.open(found) as file:
            return file.read()
    except (SyntaxError, ValueError, OSError) as error:
        raise Failure("board file {} cannot be read: {}", found, _why_no_python(error)) from error


def parse_table(text, found):
    """Return the BOARD dict of a board file's text, whole; `found`: its path. Raises Failure, with its line, if a statement is more than data."""
    return merge_into_base(own_table(text, found), found)


def merge_into_base(board, found):
    """Return `board` merged into the board of boards/ that it is like, or as it is. Raises Failure."""
    if LIKE not in board:
        return board
    base = board[LIKE]
    if not isinstance(base, str) or base not in names():
        if isinstance(base, str) and ("/" in base or "\\" in base or base.endswith(".py")):
            raise Failure("board file {}: like: {!r} is a path; a name of boards/ is wanted", found, base)
        raise Failure("board file {}: like: unknown board {!r}; known are {}", found, base, ", ".join(names()))
    if not isinstance(board.get("name"), str):
        raise Failure("board file {}: name: missing; that of {} is another machine's", found, base)
    under = own_table(read(path(base)), path(base))
    if LIKE in under:
        raise Failure("board file {}: like: {} is itself like {}; say what differs from that one", found, base, under[LIKE])
    try:
        return merge_changes(under, {key: value for key, value in board.items() if key != LIKE})
    except Failure as failure:
        raise Failure("board file {}, which is like {}: {}", found, base, failure) from None


def merge_changes(base, changes, where=""):
    """Return `base` with `changes`; both stay as they are. None removes a key. A dict is merged key by key; a list of things that have names, such as
    axes or links, name by name: known ones are changed where they stand, new ones go to the end. A dict in the place of such a list is {name:
    changes}, so that None removes one. Any other value replaces the old one. Raises Failure."""
    result = {key: copy.deepcopy(value) for key, value in base.items() if key not in changes}
    for key, change in changes.items():
        before, at = base.get(key), f"{where}{key}"
        if change is None:
            if key not in base:
                raise Failure("{}: there is none to remove", at)
        elif _has_names(before) and (isinstance(change, dict) or _has_names(change)):
            result[key] = _merge_list(before, change, at)
        elif isinstance(change, dict):
            result[key] = merge_changes(before if isinstance(before, dict) else {}, change, at + ".")
        else:
            result[key] = copy.deepcopy(change)
    return {key: result[key] for key in [*base, *changes] if key in result}


def _merge_list(before, change, at):
    """Return a list of named things with a list or a dict of changes. `at`: its key, for errors. Raises Failure."""
    if not isinstance(change, dict):
        listed = [item["name"] for item in change]
        if twice := [name for name in listed if listed.count(name) > 1]:
            raise Failure("{}: {!r} is there twice", at, twice[0])
        change = {item["name"]: item for item in change}
    named = {item["name"]: item for item in before}
    changes = {name: {"name": name, **item} if isinstance(item, dict) else item for name, item in change.items()}
    return list(merge_changes(named, changes, at + ".").values())


def _has_names(value):
    """True if a value is a list of dicts that each have a name."""
    return isinstance(value, list) and bool(value) and all(isinstance(item, dict) and isinstance(item.get("name"), str) for item in value)


def text_of_value(value, indent):
    """Return the text of a value behind `indent` columns: a value that does not fit on a line of 120 characters has a line an item."""
    text, inner = _value_text(value), " " * (indent + 4)
    if len(text) + indent <= 120 and indent or not value or not isinstance(value, (dict, list)):
        return text
    if isinstance(value, dict):
        items = "".join(f"{inner}{_value_text(key)}: {text_of_value(item, indent + 4)},\n" for key, item in value.items())
        return "{\n" + items + " " * indent + "}"
    return "[\n" + "".join(f"{inner}{text_of_value(item, indent + 4)},\n" for item in value) + " " * indent + "]"


def _value_text(value):
    """Return the text of a value on one line."""
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_value_text(key)}: {_value_text(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value_text, value)) + "]"
    return repr(value)


def own_table(text, found):
    """Return the dict of a board file itself: only the differences, if it is like another. Raises Failure."""
    try:
        with warnings.catch_warnings(action="ignore"):  # a backslash that means nothing, in a comment of several lines
            statements = ast.parse(text).body
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise Failure("board file {} cannot be read: {}", found, _why_no_python(error)) from error
    board = None
    for statement in statements:
        if isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant):
            continue  # the file's docstring
        try:
            board = _board_value(statement)
        except (ValueError, TypeError, RecursionError, MemoryError):
            line = _first_line_of_code(statement)
            raise Failure("board file {}, line {}: this is code; a board file holds BOARD = {{...}} of plain values, and comments", found, line) from None
    if not isinstance(board, dict):
        raise Failure("board file {} has no BOARD = {{...}}", found)
    return board


def _board_value(statement):
    """Return the value of `BOARD = …`. Raises ValueError, TypeError, RecursionError or MemoryError if it is another statement, or more than plain
    values."""
    if not _assigns_board(statement):
        raise ValueError
    return ast.literal_eval(statement.value)


def _assigns_board(statement):
    """True if a statement is `BOARD = …`."""
    return isinstance(statement, ast.Assign) and [getattr(target, "id", "") for target in statement.targets] == ["BOARD"]


def _first_line_of_code(statement):
    """Return the line of the first part of a statement that is no plain value; its own if all of them are."""
    waiting = [statement.value] if _assigns_board(statement) else []
    while waiting:
        node = waiting.pop()
        if not isinstance(node, (ast.Dict, ast.List, ast.Tuple, ast.Set, ast.Constant, ast.UnaryOp)):
            return node.lineno
        waiting += reversed([each for each in ast.iter_child_nodes(node) if isinstance(each, ast.expr)])
    return statement.lineno


def _why_no_python(error):
    """Return the reason why a text is no Python, in the interpreter's words and with the line."""
    if isinstance(error, SyntaxError) and error.lineno:
        return f"{error.msg} ({line_text(error.lineno)})"
    return reason(error) if str(error) else type(error).__name__


def steps_per_mm(board):
    """Return the steps per millimetre of X and Y, as floats."""
    x_axis, y_axis = board["axes"][0], board["axes"][1]
    return x_axis["steps_per_m"] / 1000, y_axis["steps_per_m"] / 1000


def travel_steps(board):
    """Return the largest coordinate of X and Y in steps; the smallest is 0."""
    return board["axes"][0]["travel_steps"], board["axes"][1]["travel_steps"]
