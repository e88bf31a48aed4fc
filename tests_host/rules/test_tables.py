"""A word is a row of one table of the firmware; what says it to people, or carries it out, is held against that table."""

import re
from pathlib import Path

import pytest
from passo.commands import INPUTS, STATUS_WORDS
from passo.machine_builder import FEATURES
from passo.options.drivers import control as drives
from passo.options.input_p import control as input_p
from passo.options.interlock.control import WORD as FORBIDS
from passo.options.output_clamp.control import WORD as CLAMP
from passo.options.output_vacuum.control import WORD as VACUUM

from host_tools.cli import status
from host_tools.clients.grbl_wire import WORDS_OF_FEW

pytestmark = pytest.mark.quick

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "firmware" / "passo" / "web" / "page"


def signals_of_the_page():
    text = (PAGE / "panel.js").read_text(encoding="utf-8")
    return set(re.findall(r"(\w): \"", re.search(r"^const SIGNALS = {(.*)}", text, re.MULTILINE).group(1)))


def test_inputs_have_names_for_people():
    letters = {letter for _, letter, _, _ in INPUTS if letter}
    assert {letter: status._PINS[letter] for letter in letters} == {letter: name for name, letter, _, _ in INPUTS if letter}
    assert signals_of_the_page() == letters | set("XYZA")


def test_inputs_are_in_the_docs_and_have_their_feature():
    text = (ROOT / "docs" / "reference" / "board-file.md").read_text(encoding="utf-8")
    named = re.findall(r"`(\w+)`", "".join(re.findall(r"^\| (`.+?) \|", text[text.index("## Names") : text.index("## Pendant")], re.MULTILINE)))
    assert [name for name, _, _, _ in INPUTS if name not in named] == []
    assert {feature for _, _, _, feature in INPUTS} - {""} <= {name for name, _, _ in FEATURES}


def test_words_of_a_status_have_names_for_people_or_are_shown_as_they_are():
    words = {word for _, word in (*STATUS_WORDS, drives._WORD, input_p._WORD, VACUUM, CLAMP, FORBIDS)}  # the last five only on boards that ask for them
    text = re.search(r"^const MORE = {(.*)}", (PAGE / "panel.js").read_text(encoding="utf-8"), re.MULTILINE).group(1)
    assert set(re.findall(r"(\w+): \"", text)) | set(status._MORE) | set(status._ELSEWHERE) <= words, "a name without its row"
    assert set(WORDS_OF_FEW) == words - {word for _, word in STATUS_WORDS if word not in WORDS_OF_FEW}
