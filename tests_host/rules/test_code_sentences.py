"""Docstrings and comments by the patterns of test_riddles.py: no sentence must be read twice."""

import re
from inspect import cleandoc
from pathlib import Path

import pytest

from test_riddles import RIDDLES, paragraphs, riddles

pytestmark = pytest.mark.quick

ROOT = Path(__file__).resolve().parents[2]
TREES = ("firmware", "host_tools", "tests_host")
# Texts, and comments as group 1. Scanning takes a thirtieth of the time of Python's parser and tokenizer, and finds the same.
TEXT_OR_COMMENT = re.compile(
    r""" "{3}(?:\\.|[^\\])*?"{3} | '{3}(?:\\.|[^\\])*?'{3} | "(?:\\.|[^"\\\n])*" | '(?:\\.|[^'\\\n])*' | \#[#\ ]*([^\n]*) """, re.DOTALL | re.VERBOSE
)


def documented(text):
    """Yield (line, paragraph) of a source's docstrings, and of its comments, each line of which counts as a sentence."""
    code, end = ":", 0  # the last character of code before a match; a module's docstring has none
    for match in TEXT_OR_COMMENT.finditer(text):
        code = (code + text[end : match.start()]).rstrip()[-1:]
        line = 1 + text.count("\n", 0, match.start())
        if match[1] is not None:
            yield line, match[1][:1].upper() + match[1][1:]
        elif code == ":" and match[0].startswith('"""') and not text[text.rfind("\n", 0, match.start()) + 1 : match.start()].strip():
            yield from ((line, paragraph) for paragraph in paragraphs(cleandoc(match[0][3:-3])))
        end = match.end()
        code = code if match[1] is not None else '"'


def riddles_of(text):
    """Return [(line, pattern, sentence)] of a source."""
    return sorted({(line, *riddle) for line, paragraph in documented(text) for riddle in riddles(paragraph)})


@pytest.mark.parametrize("tree", TREES)
def test_sentences_of_code_are_read_once(tree):
    found = [(path, *each) for path in sorted((ROOT / tree).rglob("*.py")) for each in riddles_of(path.read_text(encoding="utf-8"))]
    assert not found, "\n".join(f"{path.relative_to(ROOT)}:{line}: {sentence}\n    {RIDDLES[name][0]}" for path, line, name, sentence in found)


def test_riddles_of_code_are_found():
    text = '"""What is\nmissing."""\n\n\nasync def f():  # what is\n    """The same, and what is torn."""\n    return "# what is"  # where it lies\n'
    assert [(line, sentence) for line, _, sentence in riddles_of(text)] == [
        (1, "What is missing."), (5, "What is"), (6, "The same, and what is torn."), (7, "Where it lies"),
    ]  # fmt: skip
