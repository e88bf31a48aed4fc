"""Board files that are "like" another: merge_changes() with random dicts, its refusals, and that boards, builds and verbs get the whole."""

import ast
import copy

import pytest
from hypothesis import given
from hypothesis import strategies as st
from test_flash import board, folder, put, run_flash  # noqa: F401
from test_flash_uf2 import IMAGE
from typer.testing import CliRunner

from host_tools import boards
from host_tools.build import tree
from host_tools.build.frozen import stamp
from host_tools.build.reference import pin_rows
from host_tools.cli.main import app
from host_tools.failure import Failure
from passo.config.boardfile import check

NAMES = ("x", "y", "z", "pc")
KEYS = ("pin", "baud", "each", "items", "pins")


def name_items(items):
    """A list of things that have names."""
    return [{"name": name, **item} for name, item in zip(NAMES, items)]


plain = st.one_of(st.integers(0, 9), st.booleans(), st.sampled_from(NAMES), st.lists(st.integers(0, 9), max_size=3))
tables = st.recursive(
    st.dictionaries(st.sampled_from(KEYS), plain, max_size=4),
    lambda inner: st.dictionaries(st.sampled_from(KEYS), st.one_of(plain, inner, st.lists(inner, max_size=4).map(name_items)), max_size=4),
    max_leaves=12,
)


def is_named(value):
    return isinstance(value, list) and bool(value) and isinstance(value[0], dict)


def changes_of(base, wanted):
    """Return the dict for a file that is like `base` and has to become `wanted`."""
    found = {key: None for key in base if key not in wanted}
    for key, value in wanted.items():
        before = base.get(key)
        if is_named(before) and is_named(value):
            found[key] = changes_of({item["name"]: item for item in before}, {item["name"]: item for item in value})
        elif isinstance(before, dict) and isinstance(value, dict):
            found[key] = changes_of(before, value)
        elif before != value or type(before) is not type(value):
            found[key] = value
    return found


def sorted_names(value):
    """`value`, its lists of named things in the order of the names: a merge changes what is there where it stands."""
    if isinstance(value, dict):
        return {key: sorted_names(item) for key, item in value.items()}
    if is_named(value):
        return sorted(map(sorted_names, value), key=lambda item: item["name"])
    return value


def reachable(base, wanted):
    """False if a list of named things would have to become one of no names, or a table: {name: changes} says that a name changes."""
    for key, value in wanted.items():
        before = base.get(key)
        if is_named(before) and not is_named(value) and isinstance(value, dict):
            return False
        if is_named(before) and is_named(value):
            befores = {item["name"]: item for item in before}
            if not all(reachable(befores.get(item["name"], {}), item) for item in value):
                return False
        elif isinstance(value, dict) and not reachable(before if isinstance(before, dict) else {}, value):
            return False
    return True


@pytest.mark.quick
@given(tables, tables)
def test_a_merge_makes_what_is_wanted_and_changes_neither(base, wanted):
    if not reachable(base, wanted):
        return
    changes = changes_of(base, wanted)
    before = copy.deepcopy((base, changes))
    made = boards.merge_changes(base, changes)
    assert sorted_names(made) == sorted_names(wanted)
    assert (base, changes) == before
    assert boards.merge_changes(base, {}) == base


@given(tables, tables)
def test_what_is_merged_shares_nothing_with_the_base(base, changes):
    made = boards.merge_changes(base, changes)
    before = copy.deepcopy((base, changes))
    spoil(made)
    assert (base, changes) == before


def spoil(value):
    for item in list(value.values()) if isinstance(value, dict) else value if isinstance(value, list) else ():
        spoil(item)
    if isinstance(value, (dict, list)):
        value.clear()


def test_names_stand_where_they_stood_and_new_ones_follow():
    base = {"links": [{"name": "pc", "port": "usb"}, {"name": "serial", "port": "uart0"}]}
    listed = [{"name": "page", "port": "page"}, {"name": "serial", "port": "uart1"}]
    assert boards.merge_changes(base, {"links": listed})["links"] == [base["links"][0], listed[1], listed[0]]
    by_name = {"serial": None, "page": {"port": "page"}}
    assert boards.merge_changes(base, {"links": by_name})["links"] == [base["links"][0], {"name": "page", "port": "page"}]


# --- files


def write(path, text):
    path.write_text(f'"""A machine."""\n\nBOARD = {text}\n')
    return str(path)


WRONG = {
    '{"like": "router_9axis", "name": "mine"}': "like: unknown board 'router_9axis'; known are .*router_3axis",
    '{"like": 3, "name": "mine"}': "like: unknown board 3",
    '{"like": None, "name": "mine"}': "like: unknown board None",
    '{"like": "./router_3axis", "name": "mine"}': "like: './router_3axis' is a path; a name of boards/ is wanted",
    '{"like": "router_3axis.py", "name": "mine"}': "like: 'router_3axis.py' is a path",
    '{"like": "router_4axis", "name": "mine"}': "like: router_4axis is itself like router_3axis; say what differs from that one",
    '{"like": "router_3axis"}': "name: missing; that of router_3axis is another machine's",
    '{"like": "router_3axis", "name": "mine", "weaving": None}': "which is like router_3axis: weaving: there is none to remove",
    '{"like": "router_3axis", "name": "mine", "homing": {"latch": None}}': "homing.latch: there is none to remove",
    '{"like": "router_3axis", "name": "mine", "outputs": {"horn": None}}': "outputs.horn: there is none to remove",
    '{"like": "router_3axis", "name": "mine", "outputs": [{"name": "mist", "pin": 18}, {"name": "mist", "pin": 19}]}': "outputs: 'mist' is there twice",
    '{"like": "router_3axis", "name": "mine", "weave": 3}': "unknown key 'weave'",
    '{"like": "router_3axis", "name": "mine", "outputs": {"mist": 3}}': r"outputs\[3\]: a dict is wanted, not 3",
    '{"like": "router_3axis", "name": "mine", "tool": {"pin": 2}}': "pin 2 is claimed by axis x and by tool",
}


@pytest.mark.quick
@pytest.mark.parametrize("text", WRONG)
def test_a_wrong_one_is_one_sentence(text, tmp_path):
    with pytest.raises(Failure, match=WRONG[text]) as failed:
        boards.load(write(tmp_path / "mine.py", text))
    assert len(str(failed.value).splitlines()) == 1


MINE = '{"like": "router_3axis", "name": "mine", "axes": [{"name": "z", "travel_steps": 24000}], "outputs": {"mist": None}, "journal": None}'


@pytest.fixture
def mine(tmp_path):
    return write(tmp_path / "mine.py", MINE)


def test_the_whole_file_goes_to_a_build_and_is_printed(mine, tmp_path):
    base, whole = boards.load("router_3axis"), boards.load(mine)
    assert "journal" not in whole and "like" not in whole and whole["axes"][2] == {**base["axes"][2], "travel_steps": 24000}
    assert [item["name"] for item in whole["outputs"]] == ["enable", "reverse", "flood"] and whole["homing"] == base["homing"]
    check(whole)
    tree.build_tree(mine, tmp_path / "out")
    built = (tmp_path / "out" / "board.py").read_bytes()
    assert built == boards.board_py(mine) and ast.literal_eval(built.decode().partition("BOARD = ")[2]) == whole
    shown = CliRunner().invoke(app, ["wiring", mine, "--whole"])
    assert shown.exit_code == 0 and shown.output == built.decode()
    assert CliRunner().invoke(app, ["wiring", mine, "--whole", "--out", str(tmp_path / "x.svg")]).exit_code == 1


def test_a_board_with_passos_uf2_gets_the_whole_file(mine, folder, board):  # noqa: F811
    port, files = board
    put(files, "passo_image.py", IMAGE % stamp("rp2040"))
    result = run_flash("--port", port, "--board", mine)
    assert result.exit_code == 0, (result.output, result.exception)
    assert (files / "board.py").read_bytes() == boards.board_py(mine) and b'"like"' not in boards.board_py(mine)


@pytest.mark.quick
@pytest.mark.parametrize("name", boards.names())
def test_what_a_board_gets_says_what_the_file_says(name):
    text = boards.board_py(name).decode()
    assert boards.parse_table(text, name) == boards.load(name) and '"like"' not in text
    assert ast.literal_eval(boards.text_of(boards.load(name)).removeprefix("BOARD = ")) == boards.load(name)


@pytest.mark.quick
def test_the_list_of_pins_is_of_the_whole():
    rows = pin_rows()
    start = next(index for index, row in enumerate(rows) if row.startswith("### ") and "router_4axis" in row)
    table = rows[start + 1 : next((index for index in range(start + 1, len(rows)) if rows[index].startswith("### ")), len(rows))]
    assert any("repl" in row for row in table) and any("motor A STEP" in row for row in table)
