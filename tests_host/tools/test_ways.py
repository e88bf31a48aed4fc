"""No way through the firmware is longer than docs/reference/benchmarks.md says."""

import re

import pytest

from host_tools.bench import ways
from host_tools.resources import ROOT
from passo.app import App
from passo.motion import line_viper

pytestmark = pytest.mark.unmeasured
DOCUMENT = (ROOT / "docs" / "reference" / "benchmarks.md").read_text(encoding="utf-8")
ARCHITECTURE = (ROOT / "docs" / "inside" / "architecture.md").read_text(encoding="utf-8")


def told():
    """{way: (functions, files)}"""
    table = re.search(r"<!-- bench:ways -->\n(.*?)<!-- /bench:ways -->", DOCUMENT, re.DOTALL)[1]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()[2:]]
    return {name: (int(functions), int(files)) for name, functions, files in rows}


@pytest.mark.parametrize("way", ways.WAYS)
def test_a_way_is_no_longer_than_told(way):
    functions, files = ways.WAYS[way]()
    assert 10 < functions <= told()[way][0] and 5 < files <= told()[way][1], (functions, files)


def test_the_architecture_page_has_the_same_figures():
    rows = re.findall(r"^\| (.+) \| ([\d,; ]+) \|$", ARCHITECTURE.split("| an event passes, ")[1].split("\n\n")[0], re.MULTILINE)
    known = {name: functions for name, (functions, _) in told().items()}
    page = "a key on the board's own page, to its answer and its first words"
    ways_of = {
        "a cycle with nothing to do": ["a cycle of the main loop, nothing to do"],
        "`G1`, `G2`": ["`G1`, from its bytes to its first words", "`G2`, the same"],
        "`?`": ["`?`, to its answer"],
        "Ctrl-X in motion": ["Ctrl-X in motion, to the banner"],
        "a key on the board's own page, the first; again": [page, "the same key again"],
    }
    assert {event: [int(figure) for figure in re.findall(r"\d+", figures)] for event, figures in rows} == {
        event: [known[way] for way in ways] for event, ways in ways_of.items()
    }


def test_a_function_is_counted_once_and_a_kernel_as_one():
    machine = ways._make_machine()
    with ways.Passed() as once:
        machine.app.poll()
    with ways.Passed() as often:
        for _ in range(3):
            machine.app.poll()
    assert once.functions <= often.functions and "App.poll" in {name for _, name in once.functions}


def test_what_a_kernel_is():
    assert ways._is_kernel(line_viper.begin.__code__) and not ways._is_kernel(App.poll.__code__)
