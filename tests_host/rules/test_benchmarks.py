"""Each table of docs/reference/benchmarks.md says by which command it was measured, and on which commit; both exist.

Pages that repeat a figure have it as its table does: a new measurement changes them, too. Those of README and of `passo prove` are held by
test_promises.py, those of the timer's page by test_numbers.py.
"""

import re
import subprocess

import pytest

from host_tools.bench import main as bench
from host_tools.bench.summary import Tables, with_cache
from host_tools.resources import ROOT
from test_docs import COMMANDS

pytestmark = pytest.mark.quick
DOCUMENT = bench.DOCUMENT.read_text(encoding="utf-8")
PUBLISHED = "Figures of the others"  # by them; each row says where
COMMAND = re.compile(r"`make bench ARGS=\"?(\w+)|`passo (\w+)|`(tests_host/[\w/]*(?:\.py|/)|motion/\w+\.py)`")
MEASURED = re.compile(r"^Measured on \d{4}-\d\d-\d\d at ([0-9a-f]{8})\.$", re.MULTILINE)


def sections(document):
    """(heading, text) of each."""
    for section in re.split(r"^#+ ", document, flags=re.MULTILINE)[1:]:
        heading, _, text = section.partition("\n")
        yield heading, text


def tables(document):
    """(heading, what its section says up to the end of the table, its rows without the head)."""
    for heading, text in sections(document):
        for table in re.finditer(r"(?:^\|.*\n)+", text, re.MULTILINE):
            yield heading, text[: table.end()], table[0].splitlines()[2:]


def missing_commands(text):
    """Of the commands that a text names, those that there are not; None if it names none."""
    found = COMMAND.findall(text)
    missing = [part for part, _, _ in found if part and part not in (*bench.PARTS, "pico")]
    missing += [verb for _, verb, _ in found if verb and verb not in COMMANDS.commands]
    missing += [path for _, _, path in found if path and not (ROOT / path).exists() and not (ROOT / "firmware" / "passo" / path).exists()]
    return missing if found else None


def unmeasured(document):
    """Tables without a command that exists, and parts of `make bench` whose section does not name them."""
    faults = []
    for heading, text, rows in tables(document):
        if heading == PUBLISHED:
            continue
        if part := re.search(r"<!-- bench:(\w+) -->\n(?!.*<!-- bench:)", text, re.DOTALL):
            if not re.search(rf"make bench ARGS=\"?{part[1]}\b", text):
                faults.append(f"{heading}: no `make bench ARGS={part[1]}`")
        for each in rows if "| by |" in text else [text]:
            if missing_commands(each) != []:
                faults.append(f"{heading}: {missing_commands(each)}: {each[-100:]}")
    return faults


def test_every_table_names_its_command():
    assert unmeasured(DOCUMENT) == []


@pytest.mark.parametrize("text, other", [
    ("`make bench ARGS=status`: ", ""), ("`make bench ARGS=stops` |", "`make bench ARGS=halts` |"), ("`tests_host/pico/test_pico_halt.py` |", "`tests_host/pico/test_pico_brake.py` |"),
    ("`make bench ARGS=links` |", "a stopwatch |"),
])  # fmt: skip
def test_a_table_without_its_command_is_found(text, other):
    assert text in DOCUMENT and len(unmeasured(DOCUMENT.replace(text, other, 1))) == 1


def git(*words):
    return subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True)


def test_every_table_was_measured_on_a_commit_of_this_history():
    try:
        whole = git("rev-parse", "--is-shallow-repository").stdout.strip() == "false"
    except OSError:
        whole = False
    if not whole:
        pytest.skip("NO HISTORY: git clone without --depth, to look for the commits that were measured")
    commits = MEASURED.findall(DOCUMENT)
    assert len(commits) == len(bench.PARTS)
    history = {commit[:8] for commit in git("rev-list", "HEAD").stdout.split()}
    assert set(commits) <= history, "a commit that was rebased: measure again on one of main, or name the one it became"


def dots_a_line(mhz):
    row = Tables(DOCUMENT).row("streams", "dots of 0.1 mm, a line each", "USB", mhz)
    return int(row["measured"]) // 100 * 100


def packed_dots():
    rows = [row for row in Tables(DOCUMENT).rows("streams") if row["what"].endswith("packed") and row["link"] == "USB"]
    return min(int(row["measured"]) for row in rows)


def halt_us(by):
    return float(with_cache(Tables(DOCUMENT).row_with_cache("stops", by), "worst"))


def test_pages_have_the_figures_of_these_tables():
    def page(name):
        return re.sub(r"\s+", " ", (ROOT / "docs" / name).read_text(encoding="utf-8"))

    assert f"at some {dots_a_line('125')} dots a second over USB at 125 MHz, {dots_a_line('200')} at 200" in page("reference/gcode.md")
    for name, text in (("start", "10 000 dots a second come over USB"), ("pt", "10 000 pontos por segundo chegam pelo USB")):
        assert packed_dots() >= 10_000 and text in page(f"{name}/machines/laser.md")
    first, others = halt_us("first pin"), halt_us("other pins")
    assert f"the first one of the board file {first:g} µs, others up to {others:.0f} (" in page("use/interlock.md")
    lines = next(row for row in Tables(DOCUMENT).rows("gcode") if row["G-code on router_3axis"].startswith("lines of 0.2 mm at 490 mm/s from memory") and row["MHz"] == "125")
    assert f"| {int(with_cache(lines, 'measured')) // 10 * 10} by gcc |" in page("inside/kernels.md")
