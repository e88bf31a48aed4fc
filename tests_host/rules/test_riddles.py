"""Sentences of the documents and of error texts that must be read twice: five patterns, each with the cure, and examples of both.

A sentence is a paragraph's, a list's or a table cell's; code, headings and links' addresses are not looked at.
"""

import re
from pathlib import Path

import pytest

from host_tools.options import error_texts


pytestmark = pytest.mark.quick

ROOT = Path(__file__).resolve().parents[2]
PAGES = sorted((ROOT / "docs").rglob("*.md")) + [*ROOT.glob("*.md"), ROOT / "tests_host" / "README.md"]

# {pattern: (cure, expression)}
RIDDLES = {
    "a clause in place of a noun": (
        "name the thing: not 'what was sent is dropped' but 'the bytes sent are dropped', not 'for who has no key' but 'without a key'",
        r"^(?:(?:And|But|So) (?:\w+ )?)?(?:what|who|whoever)\b"
        r"|\b(?:of|for|by|from|than|but|with|behind|before|after|because) (?:what|who|whoever) (?!to\b)"
        r"|(?:[:;]|, and|, but|, or) (?:what|who|whoever) (?!to\b)",
    ),
    "a passive of saying": (
        "say who says it: not 'it is said each time' but 'the board sends it each time'",
        r"\b(?:is|are|was|were|be|been|being) (?:told|said|heard)\b",
    ),
    "a negation before its exception": (
        "say what is so: not 'no line is lost that …' but 'every line that … arrives'",
        r"^(?:no|nothing|none|nobody|not|neither) [^.:;]*\b(?:that|which|who|whose|unless|until|but)\b",
    ),
    "so, such for something said before": (
        "say it again, or name the figure: not 'after so long at rest' but 'after this time at rest'",
        r"^(?:so|such) (?:is|are|do|does|did|was|were|near|far|long|many|much)\b"
        r"|\b(?:is|are|was|were|be|do|does|did) so(?=[.,;:)]| (?!\w+ (?:that|as)\b))"
        r"|\bso (?:long|many|much|old)\b(?! as\b)",
    ),
    "where for if": ("if it is a condition write 'if'; if it is a place name it", r"^where\b"),
}  # fmt: skip


def paragraphs(text):
    """The paragraphs, items of lists and cells of tables of a page."""
    found = [[]]
    for line in text.splitlines():
        stripped = line.strip()
        code = line.startswith("    ") and not found[-1]
        if not stripped or stripped.startswith(("#", "<!--")) or code:
            found.append([])
        elif stripped.startswith("|"):
            found += [[cell.strip()] for cell in stripped.strip("|").split("|")] + [[]]
        elif re.match(r"(?:[-*>]|\d+\.) ", stripped):
            found.append([stripped.split(" ", 1)[1]])
        else:
            found[-1].append(stripped)
    return [" ".join(lines) for lines in found if lines]


def sentences(paragraph):
    plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", re.sub(r"`[^`]*`", "`…`", paragraph)).replace("**", "")
    return re.split(r"(?<=[.!?]) +(?=[A-Z`*0-9])", plain)


def riddles(text):
    """[(pattern, sentence)] of a paragraph. A question is no riddle; a cell of a table that is no sentence may begin with a small letter."""
    found = []
    for sentence in sentences(text):
        for name, (_, expression) in RIDDLES.items():
            if not sentence.endswith("?") and (match := re.search(expression, sentence, re.IGNORECASE)):
                if match.start() or sentence[0].isupper():
                    found.append((name, sentence))
    return found


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_sentences_are_read_once(page):
    found = [riddle for paragraph in paragraphs(page.read_text(encoding="utf-8")) for riddle in riddles(paragraph)]
    assert not found, "\n".join(f"{name}: {sentence}\n    {RIDDLES[name][0]}" for name, sentence in found)


def test_error_texts_are_read_once():
    found = [riddle for text in error_texts().values() for riddle in riddles(text[0].upper() + text[1:])]
    assert not found, "\n".join(f"{name}: {sentence}\n    {RIDDLES[name][0]}" for name, sentence in found)


EXAMPLES = {
    "a clause in place of a noun": (
        ("What does not come whole is sent again.", "A limit: who proves the key.", "A frame, and what is torn is dropped.", "It is kept for who asks."),
        ("Pick a board: what does it do?", "It says what is wrong.", "A table says who may command.", "Alarms, with what to do."),
    ),
    "a passive of saying": (("`x` is said each time.", "It has been told."), ("The board says it each time.", "Unless told otherwise.")),
    "a negation before its exception": (
        ("No line is lost that was acknowledged.", "Nothing behind a line that is refused is done."),
        ("Nothing moves.", "No motion: the machine stands until `~`.", "Every line that was acknowledged arrives."),
    ),
    "so, such for something said before": (
        ("After so long at rest it sleeps.", "So are the others.", "The machine does so before."),
        ("So it sleeps.", "It is so small that it fits.", "It goes on so long as you hold it."),
    ),
    "where for if": (("Where a board has a card, it is used.",), ("If a board has a card, it is used.", "It stands where it stood.")),
}  # fmt: skip


@pytest.mark.parametrize("name", RIDDLES)
def test_a_riddle_is_found(name):
    wrong, right = EXAMPLES[name]
    for sentence in wrong:
        assert name in [found for found, _ in riddles(sentence)], sentence
    for sentence in right:
        assert riddles(sentence) == [], sentence


def test_sentences_of_a_page_are_found():
    page = "# What is it\n\nOne. What is\n`x` here is code.\n\n    What is code\n\n| what | x |\n| --- | --- |\n| a | b. Where it is |\n\n- What two\n  lines are\n"
    found = [sentence for paragraph in paragraphs(page) for _, sentence in riddles(paragraph)]
    assert found == ["What is `…` here is code.", "Where it is", "What two lines are"]


MOST_WORDS = 16  # of a sentence, in the mean


def whole_sentences(page):
    """Words of each sentence that begins and ends as one."""
    found = [sentence for paragraph in paragraphs(page.read_text(encoding="utf-8")) for sentence in sentences(paragraph)]
    return [len(sentence.split()) for sentence in found if sentence[:1].isupper() and sentence[-1:] in ".!?:"]


@pytest.mark.parametrize("folder", ["start", "use", "pt", "."])
def test_sentences_are_short_in_the_mean(folder):
    """Of README and the pages that are read from the beginning; `.`: of all."""
    lengths = [words for page in PAGES if folder == "." or folder in page.parts or page == ROOT / "README.md" for words in whole_sentences(page)]
    assert sum(lengths) / len(lengths) <= MOST_WORDS, f"{sum(lengths) / len(lengths):.1f} words"
