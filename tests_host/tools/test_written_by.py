"""docs/use/makers.md: each row is a small file as that program writes it, drawn at its size, run, or refused by a sentence that helps; and real
programs, where they are installed."""

import re

import pytest

from host_tools.cli import jobs, stream
from host_tools.cli.check import _check_file
from host_tools.clients.grbl import Refused
from host_tools.drawings import sources
from host_tools.drawings.placement import MM_PER_PX, box_of
from host_tools.failure import Failure
from host_tools.panel import job_facts
from host_tools.panel.store import Store, gcode_lines
from host_tools.programs import gcode_file
from host_tools.programs.program_makers import advice_for
from host_tools.resources import ROOT
from host_tools.sim.job import VirtualJob
from running_router import Running
from written_by import DRAWINGS, PROGRAMS, REFUSED

PAGE = ROOT / "docs" / "use" / "makers.md"


def written(folder, name, text):
    path = folder / name
    path.write_bytes(text.encode("latin-1"))
    return path


def drawn(path):
    """Return (width and height in mm of the lines that `passo draw` draws, the Page)."""
    page = sources.open_drawing(path).outlines(0.02)
    left, top, right, bottom = box_of(list(page.layers.values()))
    return ((right - left) * MM_PER_PX, (bottom - top) * MM_PER_PX), page


@pytest.mark.parametrize("row", DRAWINGS)
def test_a_drawing_has_its_size(row, tmp_path):
    name, text, size, said = DRAWINGS[row]
    path = written(tmp_path, name, text)
    found, page = drawn(path)
    assert size is None or found == pytest.approx(size, abs=0.03)
    told = [*page.notes, *page.left_out, *["nobody sees"] * page.unseen, *["white background"] * page.backgrounds]
    assert said in " ".join(map(str, told)) and (said or not told)


@pytest.mark.parametrize("row", PROGRAMS)
def test_a_program_runs_as_it_is(row, tmp_path):
    name, text, low, high = PROGRAMS[row]
    job = VirtualJob("router_3axis")
    job.run(gcode_file.file_lines(written(tmp_path, name, text)))
    assert job.errors == []
    assert list(job.low) == pytest.approx(low, abs=0.01) and list(job.high) == pytest.approx(high, abs=0.01)


@pytest.mark.parametrize("row", REFUSED)
def test_a_refusal_says_what_to_choose(row, tmp_path, capsys):
    name, text, said = REFUSED[row]
    path = written(tmp_path, name, text)
    with pytest.raises(Failure) as failure:
        _check_file(path, "router_3axis", ((), None, None), None, None, None)
    assert said in failure.value.message() + capsys.readouterr().err


def test_a_sender_says_what_to_choose(tmp_path, capsys):
    """As the board refuses a line of a known program's file."""
    name, text, said = REFUSED["FreeCAD centroid"]
    path = written(tmp_path, name, text)
    with Running("fast") as running, pytest.raises(Refused, match="M25"):
        stream.stream(path, running.line.name, 115200, "count", False, True, None, 30.0)
    assert said in capsys.readouterr().err


def test_the_panel_says_what_to_choose(tmp_path):
    """Beside the first line at which a job would stop; a job that runs has no such words."""
    store = Store(tmp_path, gcode_lines, facts=job_facts.gcode_facts)
    settings = {100: "80", 101: "80", 102: "80", 110: "6000", 111: "6000", 112: "3000", 120: "500", 121: "500", 122: "300"}
    for name, text in (("c.nc", REFUSED["FreeCAD centroid"][1]), ("n.nc", "G21 G90\nG1 X1 F600\nM25\n"), ("g.nc", PROGRAMS["FreeCAD grbl"][1])):
        written(tmp_path, name, text)
    about = [store.facts_of(name, settings) for name in ("c.nc", "n.nc", "g.nc")]
    assert [bool(found["refused"]) for found in about] == [True, True, False]
    assert REFUSED["FreeCAD centroid"][2] in about[0]["advice"] and about[1]["advice"] == "" and "advice" not in about[2]


def test_a_store_on_the_board_says_what_to_choose(tmp_path, capsys):
    name, text, said = REFUSED["FreeCAD centroid"]
    path = written(tmp_path, name, text)
    with Running("fast", jobs={"language": "grbl", "folder": str(tmp_path / "flash")}) as running, pytest.raises(Failure, match="nothing was stored"):
        jobs.store(path, None, "grbl", port=running.line.name)
    assert said in capsys.readouterr().err


def test_files_of_nobody_in_particular_have_no_advice():
    for _name, text, *_more in [*PROGRAMS.values(), *DRAWINGS.values()]:
        assert advice_for(text.encode("latin-1")) == ""
    assert not advice_for(b"G21\nG17\nG90\nG00 X0.3937 Y7.8740\nG01 X2.3622 Y7.8740 F600\n")


def test_each_row_of_the_page_is_tried_here():
    rows = re.findall(r"^\| (?!program|---)([^|]+) \|", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    assert sorted(rows) == sorted({**DRAWINGS, **PROGRAMS, **REFUSED})
