"""Guides: each in the map and short, with its drawing current, and the same in Portuguese: headings, code, tables, pictures."""

import html
import re
import shlex
from pathlib import Path

import pytest

from host_tools import boards
from host_tools.build import pictures, reference
from host_tools.resources import ROOT, project_address
from passo.config import boardfile
from test_docs import PAGES, blocks, check

pytestmark = pytest.mark.quick

MOST_WORDS = 2500
# Pages for looking things up, not for reading from the beginning to the end; and the one walk through the code.
REFERENCE = {"docs/start/wiring.md", "docs/reference/board-file.md", "docs/reference/benchmarks.md", "docs/reference/pins.md", "docs/reference/errors.md", "docs/inside/architecture.md"}
GUIDES = sorted((ROOT / "docs" / "start" / "machines").glob("*.md"))
SECTIONS = ("Parts", "Wiring", "Try it without hardware", "Flash the board", "First motion", "What can go wrong")
LATER = {"plotter": ("The machine of 2014",)}  # sections behind these
PT = ROOT / "docs" / "pt"
# Page in Portuguese: that in English.
PAIRS = {
    PT / "README.md": ROOT / "README.md", PT / "try.md": ROOT / "docs" / "start" / "try.md",
    PT / "quick-start.md": ROOT / "docs" / "start" / "quick-start.md", PT / "machines.md": ROOT / "docs" / "reference" / "machines.md",
    PT / "everyday.md": ROOT / "docs" / "use" / "everyday.md", PT / "safety.md": ROOT / "docs" / "start" / "safety.md", PT / "class.md": ROOT / "docs" / "start" / "class.md",
    PT / "troubleshooting.md": ROOT / "docs" / "use" / "troubleshooting.md", PT / "glossary.md": ROOT / "docs" / "start" / "glossary.md",
    PT / "core.md": ROOT / "docs" / "use" / "core.md", PT / "calibration.md": ROOT / "docs" / "use" / "calibration.md", PT / "experiments.md": ROOT / "docs" / "use" / "experiments.md", PT / "map.md": ROOT / "docs" / "README.md", **{PT / "machines" / guide.name: guide for guide in GUIDES},
}  # fmt: skip
MOVED = "## Where a page went"  # one table, for all languages
NO_USB = {"two_motor_kit": "kit", "torch_manipulator": "torch", "lpt_router": "parallel-port", "plotter_2014": "plotter"}  # {board file without a link on USB: guide}
MOST_BYTES = 150_000
# Words that no sentence in Portuguese has.
ENGLISH = re.compile(r"\b(the|of|and|is|are|with|which|from|when|if|then|an|to|it|that|this|your|you|not|by|at|on|in|off|or|see)\b", re.IGNORECASE)
# Words that a Brazilian shop does not use: the ones it does; `fuso` is a lead screw, so never beside a speed or M3.
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
    """Tables made of the firmware's and of board files are as long as those are."""
    words = len(page.read_text(encoding="utf-8").split())
    if name(page) in REFERENCE:
        assert page.name in reference.PAGES or words > MOST_WORDS, "short enough by now: no reference for its length"
    else:
        assert words <= MOST_WORDS, f"{words} words: split it"


def test_every_page_is_in_the_map():
    page = ROOT / "docs" / "README.md"
    mapped = links(page.read_text(encoding="utf-8"), page)
    own = {each.resolve() for each in PAGES if PT not in each.parents} - {page, ROOT / "README.md"}
    assert not {name(each) for each in own - mapped}


def test_docs_lie_in_their_folders():
    assert {path.name for path in (ROOT / "docs").iterdir()} == {"README.md", "inside", "pt", "reference", "start", "use"}


# Former addresses of pages, which others may have linked and messages of an earlier Passo name.
OLD = (
    "architecture backlash benchmarks blackbox board-file boards build calibration class corexy drawings drivers encoders errors gcode homing interlock "
    "jobs jobs-flash kernels many network panel parking pins programs prove repl rotary safety set-up settings shop silicon site spindle states "
    "troubleshooting weaving wiring languages/README languages/frames languages/grbl languages/keys languages/plotter languages/pulses languages/torch "
    "machines/browser machines/kit machines/laser machines/mill machines/parallel-port machines/plotter machines/router machines/torch"
).split()


@pytest.mark.parametrize("old", [old for old in OLD if any(path.as_posix().endswith(f"/{old}.md") for path in PAGES)])
def test_an_old_path_says_where_the_page_went(old):
    """Of the pages that are there: some go with an option."""
    rows = dict(re.findall(r"^\| (docs/\S+) \| \[[^]]+\]\(([^)]+)\) \|$", (ROOT / "docs" / "README.md").read_text(encoding="utf-8"), re.MULTILINE))
    new = ROOT / "docs" / rows[f"docs/{old}.md"]
    assert new.is_file() and new.stem == Path(old).name


FIRST = re.compile(r"^# .+\n\n(At the end|No fim,) .+\. (Installed|Instalado): .+\.\n", re.MULTILINE)
SET_UP = re.compile(r"^    make venv && \. \.venv/bin/activate && passo examples    # ", re.MULTILINE)
BEGIN = [page for page in PAGES if page.parent.name != "docs" and ({"start", "use"} & set(page.parts) or PT in page.parents and page.name not in ("README.md", "machines.md", "map.md"))]


@pytest.mark.parametrize("page", BEGIN, ids=name)
def test_a_page_begins_with_its_end_and_its_set_up(page):
    text = page.read_text(encoding="utf-8")
    assert FIRST.match(text), "begin with the reader's result at its end, and the programs to install"
    if commands := re.search(r"^ +(?:\$ )?passo .*$", text, re.MULTILINE):
        assert SET_UP.search(text[: commands.start()]), "one line of set-up, to be pasted, before the first command"


@pytest.mark.parametrize("board, guide", NO_USB.items())
def test_a_copy_of_the_board_file_that_speaks_on_usb(board, guide):
    """As their pages say to whoever has no serial adapter."""
    loaded = boards.load(board)
    checked = boardfile.check({**loaded, "links": [{**link, "port": "usb"} for link in loaded["links"]]})
    assert [link["port"] for link in checked["links"]] == ["usb"]
    pages = [path.read_text(encoding="utf-8") for path in GUIDES if f"passo flash --board {board} " in path.read_text(encoding="utf-8")]
    assert (ROOT / "docs" / "start" / "machines" / f"{guide}.md").read_text(encoding="utf-8") in pages
    assert all('`"port": "usb"` for `"port": "uart0"`' in text for text in pages)


def test_an_adapter_has_its_reason():
    for guide in GUIDES:
        text = guide.read_text(encoding="utf-8")
        assert "ttyUSB" not in text or "MicroPython's prompt" in text, guide


def test_readme_is_read_in_a_minute():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert text.count("\n") <= 120 and len(text.split()) <= 1200
    first = text[: text.index("\n## ")]
    assert "Status: 0.1.0" in first and "No report of a real board yet" in first and "\n| " not in first
    assert first.index("Status: ") < first.index("\n    make venv && ") < first.index("\n    passo panel --demo --open "), "the first screen has no command"
    assert f"**{project_address()}**" in text.split("## Get it")[1] and "github.com" not in text


def test_the_film_begins_with_what_becomes_of_it():
    """A reader who looks once, or prints the page, sees the drawing and all of the text."""
    text = (ROOT / "docs" / "start" / "first-minute.svg").read_text(encoding="utf-8")
    seconds, shown_s = (int(re.search(rf"animation-{word}:-?(\d+)s", text)[1]) for word in ("duration", "delay"))
    assert max(float(percent) for percent in re.findall(r"([\d.]+)%,100%", text)) <= 100 * shown_s / seconds < 90


def test_the_film_shows_commands_that_exist():
    from host_tools.cli.first_minute import COMMANDS, FILM

    text = html.unescape(FILM.read_text(encoding="utf-8"))
    assert FILM.stat().st_size < MOST_BYTES and all(f">$ {command}</text>" in text for command in COMMANDS)
    for command in COMMANDS:
        check(shlex.split(command.rstrip(" &"))[1:])


@pytest.mark.parametrize("guide", GUIDES, ids=name)
def test_a_guide_goes_from_parts_to_motion(guide):
    text = guide.read_text(encoding="utf-8")
    assert tuple(re.findall(r"^## (.+)$", text, re.MULTILINE)) == SECTIONS + LATER.get(guide.stem, ())
    named = set(re.findall(r"passo wiring (\w+)", text))
    assert named and named <= set(boards.names())
    if guide.stem != "browser":
        assert "safety.md" in text and "€" in text and re.search(r"passo flash --board \w+", text)


@pytest.mark.parametrize("file, wanted", [pytest.param(*each, id=name(each[0])) for each in pictures.wiring_drawings().items()])
def test_a_drawing_is_that_of_its_board_file(file, wanted):
    assert file.read_text(encoding="utf-8") == wanted, "draw it anew: python -m host_tools.build.pictures"


def test_pictures_are_small():
    shown = [path for path in (ROOT / "docs").rglob("*") if path.suffix in (".png", ".svg", ".jpg")]
    assert len(shown) > 10 and not [(name(path), path.stat().st_size) for path in shown if path.stat().st_size > MOST_BYTES]


@pytest.mark.parametrize("page", PAIRS, ids=name)
def test_a_page_in_portuguese_is_that_in_english(page):
    portuguese, english = page.read_text(encoding="utf-8"), PAIRS[page].read_text(encoding="utf-8").partition(MOVED)[0]
    assert headings(portuguese) == headings(english)
    assert [re.sub("out/map.pt", "out/map", line) for line in code(portuguese)] == code(english)
    assert shape(portuguese) == shape(english)
    each_other = {PT / "README.md", ROOT / "README.md", PT / "map.md", page, PAIRS[page]}
    assert links(portuguese, page) - each_other == links(english, PAIRS[page]) - each_other


@pytest.mark.parametrize("page", PAIRS, ids=name)
def test_it_says_the_words_of_a_shop(page):
    text = page.read_text(encoding="utf-8").lower()
    assert not [f"{wrong}: say {right}" for wrong, right in NOT_SAID.items() if wrong in text]
    for sentence in re.split(r"[.|\n]", text):
        assert "fuso" not in sentence or not re.search(r"rpm|m3|gira|liga|inversor", sentence), sentence


def prose(text):
    """A page without code, names of files, what a program says in English, and names that are English everywhere."""
    text = without_code(re.sub(r"```.*?```", "", text, flags=re.DOTALL))
    return re.sub(r"`[^`]*`|\]\([^)]*\)|\[In English|\*[^*\n]+\*|<img [^>]*src=", "", text)


@pytest.mark.parametrize("page", PAIRS, ids=name)
def test_no_english_is_inside(page):
    assert not [line for line in prose(page.read_text(encoding="utf-8")).splitlines() if ENGLISH.search(line)]


def test_differences_are_found():
    english = "# A\n\n| a | b |\n\n    passo ports    # x\n\n![x](a.svg)\n"
    for wrong in ("## A\n", "# A\n\n| a |\n\n    passo ports\n\n![y](a.svg)\n", "# A\n\n| a | b |\n\n    passo port\n\n![y](a.svg)\n"):
        assert (headings(wrong), code(wrong), shape(wrong)) != (headings(english), code(english), shape(english))
    same = "# B\n\n| c | d |\n\n    passo ports    # y\n\n![y](a.svg)\n"
    assert (headings(same), code(same), shape(same)) == (headings(english), code(english), shape(english))
