"""Guides: each in the map and short, with its drawing current, and the same in Portuguese: headings, code, tables, pictures."""

import re

import pytest

from host_tools import boards
from host_tools.build import pictures
from host_tools.resources import ROOT
from test_docs import PAGES, blocks

pytestmark = pytest.mark.quick

MOST_WORDS = 2500
# What is looked up, and not read from the beginning to the end; and the one walk through the code.
REFERENCE = {"docs/reference/board-file.md", "docs/reference/benchmarks.md", "docs/reference/pins.md", "docs/reference/errors.md", "docs/inside/architecture.md"}
GUIDES = sorted((ROOT / "docs" / "start" / "machines").glob("*.md"))
SECTIONS = ("Parts", "Wiring", "Try it without hardware", "Flash the board", "First motion", "What can go wrong")
PT = ROOT / "docs" / "pt"
# Page in Portuguese: that in English.
PAIRS = {
    PT / "README.md": ROOT / "README.md", PT / "safety.md": ROOT / "docs" / "start" / "safety.md", PT / "class.md": ROOT / "docs" / "start" / "class.md",
    PT / "troubleshooting.md": ROOT / "docs" / "use" / "troubleshooting.md", **{PT / "machines" / guide.name: guide for guide in GUIDES},
}  # fmt: skip
MOST_BYTES = 150_000
# What a Brazilian shop does not say, and what it does; `fuso` is a lead screw, so never beside a speed or M3.
NOT_SAID = {
    "sentiu falta": "acusou", "armazenad": "guardado", " acionamento": "driver", "deseja": "quer", "origem buscada": "referenciada",
    "rotação do fuso": "rotação do spindle", "arquivo de placas": "arquivo de placa", "config.": "configuração",
    "plotadora": "plotter", "barreira": "sensor óptico", "chave óptica": "sensor óptico", "filas compactas": "linhas compactas",
    "filas de pontos": "linhas de pontos", "silício": "o chip real", "que porta": "qual porta", "ao subir": "estacionamento",
}  # fmt: skip


def name(path):
    return path.relative_to(ROOT).as_posix()


def headings(text):
    """Levels of the headings, in their order."""
    return [len(found) for found in re.findall(r"^(#+) ", without_code(text), re.MULTILINE)]


def without_code(text):
    return "\n".join(line for line in text.splitlines() if not line.startswith("    "))


def code(text):
    """Lines of code without their comments."""
    return [stripped for line in blocks(text) if (stripped := re.sub(r"\s+#.*|^#.*", "", line).rstrip())]


def shape(text):
    """Cells of each row of each table; numbers of lists; pictures by the board or file that they show."""
    rows = [line.count("|") for line in text.splitlines() if line.startswith("|")]
    items = re.findall(r"^\s*(?:\d+\.|-) ", text, re.MULTILINE)
    shown = [found.rsplit("/", 1)[-1] for found in re.findall(r"!\[[^]]*\]\(([^)]+)\)", text)]
    return rows, len(items), shown


def links(text, page):
    """Pages that a page leads to, by the English ones; anchors are another language's."""
    english = {portuguese.resolve(): page_ for portuguese, page_ in PAIRS.items()}
    found = set()
    for target in re.findall(r"(?<!!)\[[^]]*\]\(([^)#\s]+)", text):
        if not target.startswith("http"):
            path = (page.parent / target).resolve()
            found.add(english.get(path, path))
        else:
            found.add(target)
    return found


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_a_page_is_short(page):
    words = len(page.read_text(encoding="utf-8").split())
    if name(page) in REFERENCE:
        assert words > MOST_WORDS, "short enough by now: no reference for its length"
    else:
        assert words <= MOST_WORDS, f"{words} words: split it"


def test_every_page_is_in_the_map():
    for readme in (ROOT / "README.md", PT / "README.md"):
        mapped = links(readme.read_text(encoding="utf-8"), readme)
        own = {page.resolve() for page in PAGES if PT not in page.parents and page != ROOT / "README.md"}
        assert not {name(page) for page in own - mapped}, readme


@pytest.mark.parametrize("guide", GUIDES, ids=name)
def test_a_guide_goes_from_parts_to_motion(guide):
    text = guide.read_text(encoding="utf-8")
    assert tuple(re.findall(r"^## (.+)$", text, re.MULTILINE)) == SECTIONS
    named = set(re.findall(r"passo wiring (\w+)", text))
    assert named and named <= set(boards.names())
    if guide.stem != "browser":
        assert "safety.md" in text and "€" in text and re.search(r"passo flash --board \w+", text)


@pytest.mark.parametrize("file, wanted", [pytest.param(*each, id=name(each[0])) for each in pictures.drawings().items()])
def test_a_drawing_is_that_of_its_board_file(file, wanted):
    assert file.read_text(encoding="utf-8") == wanted, "draw it anew: python -m host_tools.build.pictures"


def test_pictures_are_small():
    shown = [path for path in (ROOT / "docs").rglob("*") if path.suffix in (".png", ".svg", ".jpg")]
    assert len(shown) > 10 and not [(name(path), path.stat().st_size) for path in shown if path.stat().st_size > MOST_BYTES]


@pytest.mark.parametrize("page", PAIRS, ids=name)
def test_a_page_in_portuguese_is_that_in_english(page):
    portuguese, english = page.read_text(encoding="utf-8"), PAIRS[page].read_text(encoding="utf-8")
    assert headings(portuguese) == headings(english)
    assert [re.sub("out/map.pt", "out/map", line) for line in code(portuguese)] == code(english)
    assert shape(portuguese) == shape(english)
    there = links(english, PAIRS[page]) - {PT / "README.md", ROOT / "README.md"}
    assert links(portuguese, page) - {PT / "README.md", ROOT / "README.md"} == there


@pytest.mark.parametrize("page", PAIRS, ids=name)
def test_it_says_the_words_of_a_shop(page):
    text = page.read_text(encoding="utf-8").lower()
    assert not [f"{wrong}: say {right}" for wrong, right in NOT_SAID.items() if wrong in text]
    for sentence in re.split(r"[.|\n]", text):
        assert "fuso" not in sentence or not re.search(r"rpm|m3|gira|liga|inversor", sentence), sentence


def test_differences_are_found():
    english = "# A\n\n| a | b |\n\n    passo ports    # x\n\n![x](a.svg)\n"
    for wrong in ("## A\n", "# A\n\n| a |\n\n    passo ports\n\n![y](a.svg)\n", "# A\n\n| a | b |\n\n    passo port\n\n![y](a.svg)\n"):
        assert (headings(wrong), code(wrong), shape(wrong)) != (headings(english), code(english), shape(english))
    same = "# B\n\n| c | d |\n\n    passo ports    # y\n\n![y](a.svg)\n"
    assert (headings(same), code(same), shape(same)) == (headings(english), code(english), shape(english))
