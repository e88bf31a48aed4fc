"""Each key of a board file has its place on the page, a setting, or its reason why it has none, in the documents."""

import copy
import re

import pytest
import key_places
from passo.config import boardfile

from host_tools import boards
from host_tools.build import reference
from host_tools.resources import ROOT

KEYS = sorted(reference.key_paths(reference.all_rules(boardfile)))
# Another value than any shipped board has; a number is made larger.
OTHER = {
    "homing.high_end": lambda value: "" if value else "x", "spindle.laser": lambda value: not value, "parking.at_end": lambda value: not value,
    "parking.axis": lambda value: "x" if value != "x" else "y", "idle_release_ms": lambda value: 77 if value != 77 else 78, "backlash": lambda value: {**value, "x": 44},
}  # fmt: skip


@pytest.mark.parametrize("key", KEYS)
def test_a_key_has_a_setting_or_a_reason(key):
    assert (key_places.setting_of(key) is not None) or key_places.reason_of(key)


def test_the_reasons_are_rows_of_the_page():
    page = (ROOT / "docs" / "reference" / "board-file.md").read_text(encoding="utf-8")
    section = page.partition("## Where a key is changed\n")[2].partition("\n## ")[0]
    rows = dict(re.findall(r"^\| (\w+) \| (.+) \|", section, re.MULTILINE))
    assert set(key_places.REASONS) <= set(rows) and all(len(rows[reason].split()) > 5 for reason in key_places.REASONS)
    assert not set(key_places.SETTINGS) - set(KEYS)


def boards_with(key):
    """(a board that has the key and its setting, the value there) of the shipped ones, and of a router with the options that none of them has."""
    router = boards.load("router_3axis")
    more = {**router, "parking": {}, "tool_change": {"at": [10, 20], "sensor": [250, 150]}}
    for board in [*map(boards.load, boards.names()), {**router, "parking": {}}, more]:
        try:
            whole = boardfile.check(copy.deepcopy(board))
        except boardfile.BoardError:
            continue
        found = value_of(whole, key)
        if found is not None and key_places.setting_of(key) in boards.settings_of(whole):
            yield board, found


def value_of(board, key):
    for part in key.split("."):
        if isinstance(board, (list, tuple)):
            board = board[0]
        if not isinstance(board, dict) or part not in board:
            return None
        board = board[part]
    return board


def changed(board, key, value):
    made = copy.deepcopy(board)
    place, parts = made, key.split(".")
    for part in parts[:-1]:
        place = place.setdefault(part, {})
        if isinstance(place, (list, tuple)):
            place = place[0]
    place[parts[-1]] = value
    return made


@pytest.mark.parametrize("key", sorted(key_places.SETTINGS))
def test_the_setting_has_the_value_of_the_key(key):
    """Another value in the file is another default of that setting."""
    number = key_places.setting_of(key)
    tried = 0
    for board, value in boards_with(key):
        other = OTHER[key](value) if key in OTHER else value * 0.75 if isinstance(value, float) else value * 3 // 4 if value > 3 else value + 1
        try:
            before, after = (boards.settings_of(boardfile.check(copy.deepcopy(made))) for made in (board, changed(board, key, other)))
        except boardfile.BoardError:
            continue  # this machine cannot have that value
        assert before[number] != after[number], (board["name"], value, other)
        tried += 1
    assert tried, f"no board has {key} and ${number}"
