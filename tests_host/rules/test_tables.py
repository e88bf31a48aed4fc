"""A word is a row of one table of the firmware; code that explains or carries it out is compared with that table."""

import re
from pathlib import Path

import pytest
from passo.commands import INPUTS, STATUS_WORDS
from passo.machine_builder import FEATURES

from host_tools import options
from host_tools.cli import status

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
    words = {word for _, word in STATUS_WORDS} | set(options.status_names())
    text = re.search(r"^const MORE = {(.*)}", (PAGE / "panel.js").read_text(encoding="utf-8"), re.MULTILINE).group(1)
    assert set(re.findall(r"(\w+): \"", text)) | set(status._MORE) | set(status._ELSEWHERE) <= words, "a name without its row"


def test_an_option_says_what_its_words_mean():
    """Those that its features append to STATUS_WORDS, as `WORD = (key in the report, word)`."""
    folder = ROOT / "firmware" / "passo" / "options"
    found = {word for path in folder.glob("*/control*.py") for word in re.findall(r'^_?WORD = \("\w+", "(\w+)"\)', path.read_text(encoding="utf-8"), re.MULTILINE)}
    assert len(found) > 3 and found == set(options.status_names())
