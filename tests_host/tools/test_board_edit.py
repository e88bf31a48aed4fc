"""Values of board files, changed where they stand: the same as in the dict, and every comment stays."""

import ast
import copy
import io
import tokenize

import pytest
from hypothesis import given, settings, strategies as st

from host_tools import board_edit, boards
from host_tools.failure import Failure

VALUES = st.one_of(st.integers(-(10**6), 10**6), st.booleans(), st.text("ab é\"'\\#,}", max_size=6), st.lists(st.integers(0, 9), max_size=3),
                   st.dictionaries(st.sampled_from(["pin", "kind"]), st.integers(0, 9), min_size=1), st.just([3, "a" * 130]))  # fmt: skip


def own_values(text):
    return next(ast.literal_eval(each.value) for each in ast.parse(text).body if isinstance(each, ast.Assign))


def comments(text):
    return [token.string for token in tokenize.generate_tokens(io.StringIO(text).readline) if token.type == tokenize.COMMENT]


def paths_of(value, path=()):
    """Each place of a board's dict that a path can name."""
    if isinstance(value, dict):
        found = value.items()
    elif isinstance(value, list) and value and all(isinstance(each, dict) and "name" in each for each in value):
        found = [(each["name"], each) for each in value]
    else:
        return
    for key, each in found:
        if key not in ("name", "like"):
            yield (*path, key)
            yield from paths_of(each, (*path, key))


FILES = [path for path in map(boards.path, boards.names()) if list(paths_of(own_values(path.read_text(encoding="utf-8"))))]


def in_base(board, path):
    """True if the board that this one is like has something there."""
    return "like" in board and tuple(path) in set(paths_of(own_values(boards.path(board["like"]).read_text(encoding="utf-8"))))


def changed(board, path, value):
    """The dict with one value, by the meaning of a path; None removes."""
    board = copy.deepcopy(board)
    at, last = board, len(path) - 1
    for depth, key in enumerate(path):
        known = [each["name"] for each in at] if isinstance(at, list) else list(at)
        if depth == last:
            if value is None and (isinstance(at, list) or not in_base(board, path)):
                at.pop(known.index(key) if isinstance(at, list) else key)
            elif isinstance(at, list):
                at[known.index(key)] = value
            else:
                at[key] = value
            return board
        if key not in known:
            if isinstance(at, list):
                at.append({"name": key})
                known.append(key)
            else:
                at[key] = {}
        at = at[known.index(key)] if isinstance(at, list) else at[key]
    return board


@settings(max_examples=300, deadline=None)
@given(st.data())
def test_values_are_those_of_the_dict_and_comments_stay(data):
    text = data.draw(st.sampled_from(FILES)).read_text(encoding="utf-8")
    for _ in range(data.draw(st.integers(1, 4))):
        board = own_values(text)
        path = data.draw(st.sampled_from(sorted(paths_of(board))))
        more = data.draw(st.lists(st.sampled_from(["new", "other"]), max_size=2))
        if more and not isinstance(changed(board, path, 1), dict):
            more = []
        parent = board
        for key in path:
            parent = next(each for each in parent if each["name"] == key) if isinstance(parent, list) else parent[key]
        if more and not isinstance(parent, dict):
            more = []
        if len(more) == 2 and not isinstance(parent.get(more[0], {}), dict):
            more = more[:1]  # a plain value has nothing within
        named = isinstance(parent, dict) and "name" in parent and not more
        value = data.draw(VALUES if more or not named else st.just({"name": path[-1], "pin": 7}))
        edited = board_edit.set_values(text, {".".join((*path, *more)): value})
        assert own_values(edited) == changed(board, (*path, *more), value)
        if not isinstance(parent, (dict, list)):  # comments inside a dict or list that is replaced as a whole are lost
            assert comments(edited) == comments(text)
        text = edited


@settings(max_examples=150, deadline=None)
@given(st.data())
def test_none_removes_or_is_written(data):
    text = data.draw(st.sampled_from(FILES)).read_text(encoding="utf-8")
    board = own_values(text)
    path = data.draw(st.sampled_from(sorted(paths_of(board))))
    assert own_values(board_edit.set_values(text, {".".join(path): None})) == changed(board, path, None)


def test_what_a_file_has_added_itself_is_removed_whole():
    text = board_edit.set_values('BOARD = {"name": "mine", "like": "lpt_router"}\n', {"inputs.probe": {"pin": 15}, "inputs.stop": None})
    assert own_values(board_edit.set_values(text, {"inputs.probe": None}))["inputs"] == {"stop": None}


@pytest.mark.parametrize("text", ["BOARD = {}\n", 'BOARD = {"a": 1}', 'BOARD = {"a": 1,}', 'BOARD = {\n    "a": 1  # é, one\n}\n', 'BOARD = {\n    "a": 1,  # one\n    # the end\n}\n',
                                  'BOARD = {"like": "x",\n         "a": [{"name": "x", "b": 1}]}\n'])  # fmt: skip
@pytest.mark.parametrize("path", ["n", "n.m", "a", "n.m.o"])
def test_what_is_not_there_is_added(text, path):
    edited = board_edit.set_values(text, {path: 5})
    assert own_values(edited) == changed(own_values(text), tuple(path.split(".")), 5) and comments(edited) == comments(text)


@pytest.mark.parametrize("pair, value", [("a.b=250", 250), ("a= 'x'", "x"), ("a=grbl", "grbl"), ("a=[2, 5]", [2, 5]), ("a=None", None), ("a=", ""), ("a=0x1f", 31), ("a=x()", "x()")])
def test_a_pair(pair, value):
    assert board_edit.parse_pair(pair)[1] == value


@pytest.mark.parametrize("pair", ["a", "=3", "a..b=3", "a b=3", ".a=3", "a.=3"])
def test_no_pair(pair):
    with pytest.raises(Failure, match="is not KEY=VALUE"):
        board_edit.parse_pair(pair)


@pytest.mark.parametrize("path, wrong", [("name.x", "name is a plain value, and has no x"), ("axes.q", "q: there is none"), ("axes.x.pins.first", "first: there is none")])
def test_what_has_no_such_place(path, wrong):
    with pytest.raises(Failure, match=wrong):
        board_edit.set_values(boards.path("lpt_router").read_text(encoding="utf-8"), {path: 1})
