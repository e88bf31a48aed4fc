"""Board files with a mistake in them: every value of every shipped file in turn, replaced by others of wrong types and shapes, or taken away;
and the sections of the others put into it.
What is refused is refused by BoardError, with a sentence."""

import copy
import importlib
import pkgutil

import pytest

import boards
from passo.config.board_error import BoardError
from passo.config.boardfile import check

NAMES = sorted(module.name for module in pkgutil.iter_modules(boards.__path__))
WRONG = (
    None, True, -1, 0, 3, 2**40, 1.5, float("nan"), "", "x", "x" * 90, " ", "!", "x |", "uart9", b"x", [], [1], [[]], [None], ["x"], [-1, "x"], [2, 2],
    {}, {"x": 1}, {1: 2}, {None: None}, {"x": {}}, {"x": "x"}, {"x": None}, {"masks": 1}, (), (1, 2), {1}, object, "x+",
)  # fmt: skip
GONE = object()


def places(value, path=()):
    """The paths of all values inside a board file."""
    yield path
    inside = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, (list, tuple)) else ()
    for key, each in inside:
        yield from places(each, (*path, key))


def broken(board, path, value):
    """A copy of the board with another value at the path."""
    if not path:
        return value
    made = copy.deepcopy(board)
    part = made
    for key in path[:-1]:
        part = part[key]
    if value is GONE:
        del part[path[-1]]
    else:
        part[path[-1]] = value
    return made


def mutants(board):
    for path in places(board):
        for value in WRONG:
            yield path, value
        if path:
            yield path, GONE
    for name in NAMES:  # and what other boards have
        for key, value in importlib.import_module("boards." + name).BOARD.items():
            if board.get(key) != value:
                yield (key,), value
            if key not in board:
                for wrong in WRONG:
                    yield (key,), wrong
                for inside in places(value):
                    if inside:
                        yield (key,), broken(value, inside, GONE)


@pytest.mark.parametrize("name", NAMES)
def test_a_mistake_is_a_board_error(name):
    board = importlib.import_module("boards." + name).BOARD
    found = {}
    refused = 0
    for path, value in mutants(board):
        try:
            check(broken(board, path, value))
        except BoardError as error:
            assert str(error)
            refused += 1
        except Exception as error:
            trace = error.__traceback__
            while trace.tb_next:
                trace = trace.tb_next
            found.setdefault(f"{trace.tb_frame.f_code.co_filename}:{trace.tb_lineno} {type(error).__name__}", (path, value))
    assert not found, found
    assert refused > 500
