"""Everything that the documents name exists: their links, their commands, their files; generated pages are current."""

import re
import shlex

import pytest
import typer
from typer.main import get_command

from host_tools import boards
from host_tools.build import reference
from host_tools.cli.main import app
from host_tools.resources import ROOT
from passo.config import boardfile
from passo.protocols.gcode.codes import CODES
from passo.protocols.gcode.words import M_CODES

pytestmark = pytest.mark.quick

PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), ROOT / "tests_host" / "README.md"])
FENCED = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
# Placeholders of the documents: {placeholder: a value that works}.
STANDS_FOR = {"PORT": "/dev/ttyACM0", "NAME": "plotter_2014", "NUMBER": "1", "FILE": "job.gcode", "TCP": "5001"}
COMMANDS = get_command(app)
UsageError = typer.BadParameter.__base__  # click's, or that of the click inside newer Typers


def pages(*without):
    return [pytest.param(path, id=path.relative_to(ROOT).as_posix()) for path in PAGES if path.name not in without]


def spans(text):
    """Pieces of inline code, without what stands in blocks."""
    flat = FENCED.sub("", text)
    return re.findall(r"`([^`\n]+)`", "\n".join(line for line in flat.splitlines() if not line.startswith("    ")))


def blocks(text):
    """Lines of code blocks, indented or fenced."""
    lines = [line[4:] for line in FENCED.sub("", text).splitlines() if line.startswith("    ")]
    return lines + [line for block in FENCED.findall(text) for line in block.splitlines()[1:-1]]


def anchor(heading):
    """GitHub's name of a heading."""
    text = re.sub(r"[^\w\- ]", "", heading.replace("`", "").strip().lower())
    return text.replace(" ", "-")


def anchors(path):
    text = FENCED.sub("", path.read_text(encoding="utf-8"))
    return {anchor(line.lstrip("#")) for line in text.splitlines() if re.match(r"#+ ", line)}


@pytest.mark.parametrize("page", pages())
def test_links_resolve(page):
    broken = []
    for target in re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf-8")):
        if re.match(r"https?:|mailto:", target):
            continue
        name, _, part = target.partition("#")
        path = (page.parent / name).resolve() if name else page
        if not path.exists() or part and part not in anchors(path):
            broken.append(target)
    assert not broken


def shown_commands(text, verb, mentioned=True):
    """Return a command's uses, without their comments: [words]; `mentioned`: in a line of text, too."""
    found = []
    lines = blocks(text) + (spans(text) if mentioned else [])
    for line in [command for line in lines for command in line.split(" && ")]:
        line = re.sub(r"^\$ ", "", line.strip())
        match = re.match(rf"(?:\.venv/bin/)?{verb}(?: (.*))?$", line)
        if match:
            words = shlex.split(match[1] or "", comments=True)
            found.append([STANDS_FOR.get(word, word) for word in words])
    return found


def check(words):
    """Parses the words of a `passo` command as the command itself does; nothing is carried out."""
    command, words = COMMANDS, list(words)
    while hasattr(command, "commands"):
        if not words or words[0].startswith("-"):
            return
        name = words.pop(0)
        assert name in command.commands, f"there is no passo {name}"
        command = command.commands[name]
    if "--help" in words or "…" in words or words and words[-1] == "...":
        return
    if not words and any(parameter.required for parameter in command.params):
        return  # its name alone: a mention
    command.make_context(command.name, words)


@pytest.mark.parametrize("page", pages())
def test_commands_exist(page):
    for words in shown_commands(page.read_text(encoding="utf-8"), "passo"):
        if words[:1] in (["VERB"], []):
            continue
        try:
            check(words)
        except UsageError as error:
            pytest.fail(f"passo {shlex.join(words)}: {error.format_message()}")


def test_a_wrong_command_is_found():
    for words in (["plan"], ["board", "--bord", "x"], ["emulate", "--tcp", "many"], ["torch", "fly"]):
        with pytest.raises((AssertionError, UsageError)):
            check(words)


@pytest.mark.parametrize("page", pages())
def test_targets_of_make_exist(page):
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    for words in shown_commands(page.read_text(encoding="utf-8"), "make"):
        for word in words:
            if re.fullmatch(r"[a-z-]+", word):
                assert word in targets, f"make {word}"


@pytest.mark.parametrize("page", pages("benchmarks.md"))
def test_files_exist(page):
    """Paths in inline code: of the project, of firmware/passo, or of the page's own folder."""
    text = page.read_text(encoding="utf-8")
    named = {span for span in spans(text) if re.fullmatch(r"[\w./]+/[\w.]+\.(py|md|toml|png|json|csv|txt)", span)}
    roots = ROOT, ROOT / "firmware" / "passo", ROOT / "firmware", page.parent
    made = re.compile(r"out/|build/|boards/mine|passo/files.txt|passo/stamp.txt|.*/(wheel|output_lamp|beeper|service|input_runout|drive_l298)/\w+\.\w+$")  # files that commands write, and files of the reader
    missing = [name for name in named if not made.match(name) and not any((root / name).exists() for root in roots)]
    assert not missing


@pytest.mark.parametrize("page", pages())
def test_boards_exist(page):
    for words in shown_commands(page.read_text(encoding="utf-8"), "passo"):
        for option, value in zip(words, words[1:]):
            if option == "--board" and not value.endswith(".py"):
                assert value in boards.names()


@pytest.mark.parametrize("name", reference.PAGES)
def test_made_pages_are_current(name):
    wanted = reference.page_text(name)
    assert (reference.DOCS / name).read_text(encoding="utf-8") == wanted, "write it anew: python -m host_tools.build.reference"


def test_every_key_has_a_meaning():
    _, meanings = reference.section_texts()
    assert set(reference.key_paths(reference.all_rules(boardfile))) == set(meanings)


def source():
    """All Python text of the project."""
    folders = ROOT / "firmware", ROOT / "host_tools"
    return "\n".join(path.read_text(encoding="utf-8") for folder in folders for path in folder.rglob("*.py"))


def test_functions_exist():
    """`Class.method` and `module.py` in the pages that walk through the code."""
    text = source()
    methods = set(re.findall(r"^    def (\w+)", text, re.MULTILINE))
    classes = set(re.findall(r"^class (\w+)", text, re.MULTILINE))
    modules = {path.name for folder in ("firmware", "host_tools", "boards") for path in (ROOT / folder).rglob("*.py")}
    missing = []
    for page in (ROOT / "docs" / "inside" / "architecture.md", ROOT / "docs" / "inside" / "build.md", ROOT / "CONTRIBUTING.md"):
        for span in spans(page.read_text(encoding="utf-8")):
            owner, _, name = span.partition(".")
            if re.fullmatch(r"[A-Z]\w+\.\w+", span) and not (owner in classes and name in methods):
                missing.append(f"{page.name}: {span}")
            if re.fullmatch(r"\w+\.py", span) and span not in modules | {"board.py"} and not span.startswith(("check_", "test_")):
                missing.append(f"{page.name}: {span}")
    assert not missing


def codes_of_the_page():
    """G and M codes in hundredths, as the firmware has them, of the table of docs/reference/gcode.md."""
    text = (ROOT / "docs" / "reference" / "gcode.md").read_text(encoding="utf-8")
    table = text[text.index("## Codes") : text.index("Letters:")]
    found = set()
    for cell in re.findall(r"^\| ([GM]\d[^|]*) \|", table, re.MULTILINE):
        for first, last in re.findall(r"([GM][\d.]+)(?: … ([GM][\d.]+))?", cell):
            low, high = (round(float(code[1:]) * 100) for code in (first, last or first))
            step = 10 if low % 100 else 100
            found |= {code + (M_CODES if first[0] == "M" else 0) for code in range(low, high + 1, step)}
    return found


def test_the_codes_are_those_that_are_understood():
    assert codes_of_the_page() == set(CODES)


def test_the_packets_are_those_of_the_plotter():
    from passo.protocols.plotter import host as plotter

    text = (ROOT / "docs" / "reference" / "languages" / "plotter.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| ([A-Z ]+) \| `(.+?)`(?: (\d+))? \|", text, re.MULTILINE)
    shown = {}
    for names, letters, number in rows:
        shown.update(zip(names.split(), letters.split()))
        assert not number or ord(letters) == int(number)
    assert {name: chr(byte) for name, byte in plotter.COMMANDS.items()} == shown


def test_the_frames_are_those_of_the_torch():
    from passo.protocols.torch import protocol as torch

    text = (ROOT / "docs" / "reference" / "languages" / "torch.md").read_text(encoding="utf-8")
    table = text[text.index("## The frames") :]
    shown = {int(code, 16) for code in re.findall(r"(?<![\w])([0-9A-F]{2})(?= |`)", table)} - {0xFF}
    assert shown >= set(torch.CODES.values()) | set(torch.OF_OPTIONS)
