"""Names that differ by number have one each: kinds of commands and events, errors, notices, fields of rows.

Numbers that users know keep their meaning for ever: golden/numbers.txt has each error, notice and setting, numbers.txt of an option's tests its own.
A new one of core is a line more:

    python tests_host/rules/test_numbers.py > tests_host/golden/numbers.txt
"""

import ast
import re
from pathlib import Path

import pytest

from host_tools import boards
from passo.config.boardfile import check

pytestmark = pytest.mark.quick

PASSO = Path(__file__).resolve().parents[2] / "firmware" / "passo"
GOLDEN = PASSO.parents[1] / "tests_host" / "golden" / "numbers.txt"
CONSTANT = re.compile(r"^([A-Z][A-Z0-9_]*) = const\((-?(?:0x)?[0-9A-Fa-f]+)\)", re.MULTILINE)


def groups(text, of_rows):
    """Lists of (name, number) that stand together: a paragraph; of fields of rows from each 0 and each prefix on."""
    for paragraph in re.split(r"\n\s*\n", text):
        found, prefix = [], None
        for name, number in CONSTANT.findall(paragraph):
            number = int(number, 0)
            if of_rows and (number == 0 or name.split("_")[0] != prefix):
                yield found
                found = []
            prefix = name.split("_")[0]
            found.append((name, number))
        yield found


def twice(text, of_rows=False):
    faults = []
    for group in groups(text, of_rows):
        names = {}
        for name, number in group:
            if number in names:
                faults.append((names[number], name, number))
            names[number] = name
    return faults


def parts(module):
    """The texts of a module of the vocabulary: the core's, and those of the same name in folders of options and languages."""
    return [path.read_text(encoding="utf-8") for path in [PASSO / module, *sorted(PASSO.glob(f"*/*/{module}"))]]


def paragraphs(text):
    """{first name of a paragraph: {name: number}}."""
    return {group[0][0]: dict(group) for group in groups(text, False) if group}


def kinds_of_commands():
    """[(name, number)] of all commands: of the core those that begin with BAD, of an option the first paragraph."""
    core, *own = [paragraphs(text) for text in parts("commands.py")]
    return list(core["BAD"].items()) + [row for each in own for row in next(iter(each.values())).items()]


@pytest.mark.parametrize("module", ["commands.py", "errors.py", "records.py"])
def test_numbers_are_unique(module):
    core, *own = parts(module)
    assert len(CONSTANT.findall(core)) > 50
    assert [fault[:2] for text in (core, *own) for fault in twice(text, of_rows=module == "records.py")] == []


def test_numbers_of_core_options_and_languages_are_unique():
    """Kinds of commands; errors and alarms; notices."""
    errors = [(name, int(number)) for text in parts("errors.py") for name, number in CONSTANT.findall(text)]
    notices = [row for row in errors if row[0].startswith("NOTICE_")]
    for found in (kinds_of_commands(), [row for row in errors if row not in notices], notices):
        assert len({number for _, number in found}) == len({name for name, _ in found}) == len(found), sorted(found, key=lambda row: row[1])


def test_kinds_are_one_paragraph():
    """Also those that were added last: else nothing would compare them."""
    kinds = {name for name, _ in kinds_of_commands()}
    firmware = "".join(path.read_text() for path in PASSO.rglob("*.py"))
    used = set(re.findall(r"(?:Command|Motion)\(\s*(?:commands\.)?([A-Z_]+)\b", firmware))
    used = {name for name in used if name[0] != "_"}
    assert {"LINE", "MORE", "ADMIT", "HELLO"} <= used and used <= kinds, used - kinds


def test_the_rule_sees_it():
    assert twice("A = const(1)\nB = const(2)\nC = const(0x1)\n\nD = const(1)\n") == [("A", "C", 1)]
    assert twice("ROW_A = const(0)\nROW_B = const(1)\nROW_C = const(1)\nIN_A = const(0)\n", True) == [("ROW_B", "ROW_C", 1)]


def test_the_page_of_the_timer_has_its_numbers():
    """The fastest rate is that of the player's shortest word; edges and the processor's share are those of the bench's table."""
    root = PASSO.parents[1]
    page = (root / "docs" / "use" / "timer.md").read_text(encoding="utf-8")
    source = (root / "firmware" / "passo" / "options" / "player_timer" / "port_rp2.py").read_text(encoding="utf-8")
    ticks = int(re.search(r"SHORTEST_TICKS = const\((\d+)\)", source).group(1))
    assert f"{12_500 // ticks} kHz: a word of {ticks * 80 // 1000} µs" in page
    bench = (root / "docs" / "reference" / "benchmarks.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| [13] \| (\d+) \| \d+ \| (\d+) \| (no|yes) \|.* \| ([\d.]+) \| (\d+)% \|$", bench, re.MULTILINE)
    assert len(rows) == 24 and {late for _, late, *_ in rows} == {"0"}
    worst = {cache: max(float(us) for _, _, with_cache, us, _ in rows if with_cache == cache) for cache in ("no", "yes")}
    assert f"within {worst['no']:g} µs of their time; with the flash cache within {worst['yes']:g} µs" in page
    left = [int(percent) for khz, _, _, _, percent in rows if khz == "25"]
    assert f"{100 - max(left)} to {100 - min(left)} % at 25 kHz" in page


# --- what users know by number


def settings_of(source):
    """(number, name) of settings that a manifest writes as a table: {41: ("parking", …)}."""
    for node in ast.walk(ast.parse(source)):
        for key, value in zip(node.keys, node.values, strict=True) if isinstance(node, ast.Dict) else ():
            if isinstance(key, ast.Constant) and type(key.value) is int and isinstance(value, ast.Tuple) and isinstance(value.elts[0], ast.Constant):
                yield key.value, value.elts[0].value


def known():
    """(kind, number, name) of all errors, notices and settings: of core, of each board, and of each option's manifest."""
    for text in parts("errors.py"):
        for name, number in CONSTANT.findall(text):
            yield "notice" if name.startswith("NOTICE_") else "error", int(number), name
    for board in [check(boards.load(name)) for name in boards.names()]:
        yield from (("setting", number, rule[0]) for number, rule in boards.settings_of(board).items())
    for path in PASSO.glob("options/*/manifest.py"):
        yield from (("setting", number, name) for number, name in settings_of(path.read_text(encoding="utf-8")))


def rows():
    """[kind, number, name] of golden/numbers.txt, and of numbers.txt of options."""
    files = [GOLDEN, *sorted(GOLDEN.parents[1].glob("options/*/numbers.txt"))]
    return [line.split() for path in files for line in path.read_text(encoding="utf-8").splitlines()]


def golden():
    """Return the meaning of each number: {(kind, number): name}."""
    return {(kind, int(number)): name for kind, number, name in rows()}


def changes(found, meanings):
    """Numbers of `found` that are new, or that mean something else than in `meanings`; and names whose number has changed."""
    numbers = {(kind, name): number for (kind, number), name in meanings.items()}
    return sorted({
        f"{kind} {number} {name}" for kind, number, name in found
        if meanings.get((kind, number)) != name or numbers.get((kind, name)) != number
    })  # fmt: skip


def test_numbers_that_users_know_never_change():
    """A setting goes with its option; its number is given to nothing else."""
    found, meanings = set(known()), golden()
    assert len(rows()) == len(meanings) > 200, "a number stands there twice"
    assert changes(found, meanings) == [], "new lines go into golden/numbers.txt; those that are there stay as they are"
    gone = {(kind, number) for kind, number in meanings if kind != "setting"} - {(kind, number) for kind, number, _ in found}
    assert not gone, "an error or a notice that a user may look up is gone"


def test_a_changed_number_is_seen():
    meanings = {("setting", 41): "parking", ("error", 1): "LETTER"}
    assert changes([("setting", 41, "parking"), ("error", 1, "LETTER")], meanings) == []
    assert changes([("setting", 42, "parking")], meanings) == ["setting 42 parking"]
    assert changes([("setting", 41, "beeper")], meanings) == ["setting 41 beeper"]
    assert changes([("setting", 9, "beeper")], meanings) == ["setting 9 beeper"]
    assert list(settings_of('rules = {41: ("parking", 0, 1, 0, 1)}')) == [(41, "parking")]


if __name__ == "__main__":
    elsewhere = {line for path in GOLDEN.parents[1].glob("options/*/numbers.txt") for line in path.read_text(encoding="utf-8").splitlines()}
    print("\n".join(row for row in [f"{kind} {number} {name}" for kind, number, name in sorted(set(known()))] if row not in elsewhere))
