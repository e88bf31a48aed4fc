"""The surface of Passo for people and programs: golden/surface.txt lists it, of an option surface.txt beside its tests; an entry can go only by a change of the
list.

    python tests_host/rules/test_surface.py > tests_host/golden/surface.txt      # after something new, or something removed on purpose

A line is a command of `passo` with an option, a setting, a board-file key, a code, a `$` line, a path of HTTP, an order of a page with
a field, or a field of a status report.
"""

import re
from pathlib import Path

import pytest

pytestmark = pytest.mark.quick

ROOT = Path(__file__).resolve().parents[2]
LIST = ROOT / "tests_host" / "golden" / "surface.txt"


def verbs():
    from host_tools.cli.main import app
    from typer.main import get_command

    def walk(command, path):
        yield path
        for parameter in command.params:
            for name in parameter.opts + parameter.secondary_opts if parameter.param_type_name == "option" else [parameter.name.upper()]:
                yield f"{path} {name}"
        for name, inner in getattr(command, "commands", {}).items():
            yield from walk(inner, f"{path} {name}")

    return walk(get_command(app), "passo")


def settings():
    from passo.config.boardfile import check

    from host_tools import boards

    for name in boards.names():
        for number, rule in boards.settings_of(check(boards.load(name))).items():
            yield f"setting ${number} {rule[0]}"


def board_keys():
    from passo.config import boardfile

    from host_tools import boards
    from host_tools.build.reference import all_rules, key_paths

    return [f"board file {key}" for key in key_paths(all_rules(boardfile))] + [f"board file {boards.LIKE}"]


def codes():
    from passo.protocols.gcode.codes import CODES
    from passo.protocols.gcode.words import M_CODES

    for code in CODES:
        letter, number = ("M", code - M_CODES) if code >= M_CODES else ("G", code)
        yield f"G-code {letter}{number / 100:g}"


def statuses():
    from passo.commands import STATUS_WORDS
    from passo.config.board_error import inputs_of
    from passo.config.boardfile import check

    from host_tools import boards

    rows = {row for name in boards.names() for row in inputs_of(check(boards.load(name)))}
    return [f"status {row[1]}" for row in STATUS_WORDS] + [f"input {row[0]} {row[1]}" for row in rows]


PAGES = ("firmware/passo/protocols/page", "firmware/passo/options/jobs", "firmware/passo/options/weaving", "firmware/passo/web", "host_tools/page", "host_tools/panel")

# {kind: (folders, files, expression)} of texts in the source.
TEXTS = {
    "$ line": (("firmware/passo/protocols/grbl", "firmware/passo/options"), "**/*.py", r'"(\$[A-Z#$+]*=?)'),
    "HTTP path": (("firmware/passo/web", "firmware/passo/protocols/torch"), "*.py", r'b?"(/[A-Za-z.]*)"'),
    "panel path": (("host_tools/panel",), "*.py", r'app\.(?:get|post)\("([^"]*)"'),
    "page order": (PAGES, "*.py", r'"([a-z_]+)"(?:: |\] = )self\._[a-z]\w*[,}\n]'),
    "page order field": (PAGES, "*.py", r'(?:(?:number_field|text_field|positions_field)\(order, |order\.get\()"(\w+)"'),
    "page message": (PAGES, "*.py", r'"t": "(\w+)"'),
    "page card": (("firmware/passo/web/page",), "*.html", r'id="card-(\w+)"'),
}


def texts(root=ROOT):
    for kind, (folders, files, expression) in TEXTS.items():
        for folder in folders:
            for path in (root / folder).glob(files):
                for found in re.findall(expression, path.read_text(encoding="utf-8")):
                    yield f"{kind} {found}"


def of_options():
    """Lines of options: surface.txt beside their tests."""
    return {line for path in LIST.parents[1].glob("options/*/surface.txt") for line in path.read_text(encoding="utf-8").splitlines()}


def surface():
    return sorted({*verbs(), *settings(), *board_keys(), *codes(), *statuses(), *texts()})


def test_nothing_that_is_promised_is_lost():
    of_core = LIST.read_text(encoding="utf-8").splitlines()
    assert len(of_core) > 800 and of_core == sorted(of_core)
    listed = set(of_core) | of_options()
    assert len(listed) > len(of_core) + 50
    lost = listed - set(surface())
    assert not lost, sorted(lost)


@pytest.mark.parametrize("kind", ["passo", "setting", "board file", "G-code", "status", "input", *TEXTS])
def test_each_kind_is_found(kind):
    """An expression that finds nothing would guard nothing."""
    assert [line for line in surface() if line.startswith(kind + " ")]


if __name__ == "__main__":
    print("\n".join(line for line in surface() if line not in of_options()))
