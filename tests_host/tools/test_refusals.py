"""The error text of a refused line: the same from the sender and from the check."""

import pytest

from host_tools import boards
from host_tools.cli.check import _check_file
from host_tools.clients.refusal import explain_error
from host_tools.failure import Failure
from host_tools.panel import job_facts
from host_tools.panel.languages import create
from host_tools.panel.store import Store, gcode_lines
from passo import error_texts, errors


@pytest.mark.parametrize("line, wanted", [
    ("N3 G1 X5*18", "error 1, checksums such as *18 are for 3D printers"), ("*5", "error 1, "),
    ("G1 X9999 F600", "error 15, the target is outside the machine's travel"), ("G81 X5 F600", "error 28, a word is missing: P or L; R, Z or Q"),
])  # fmt: skip
def test_check_says_what_helps(line, wanted, tmp_path, capsys):
    file = tmp_path / "a.nc"
    file.write_text(f"G21 G90\n{line}\nG0 X1\n")
    with pytest.raises(Failure, match="the first is line 2"):
        _check_file(file, "router_3axis", ((), None, None), None, None, None)
    assert wanted in capsys.readouterr().err


def test_a_sender_says_the_same():
    assert explain_error("error:1", b"G1X1*7").startswith("error 1, checksums such as *7")
    assert explain_error("error:1", b"G1X1*7Y") == explain_error("error:1") == f"error 1, {error_texts.TEXTS[errors.LETTER]}"


def test_the_page_says_what_in_the_line_is_wrong(tmp_path):
    """Of a typed line, and beside the first line at which a job would stop."""
    machine = create("grbl", boards.load("router_3axis"), lambda data: None, lambda event: None).machine
    assert machine.cause(errors.LETTER, b"G1X5*18").startswith("checksums such as *18") and machine.cause(errors.LETTER, b"5") == ""
    store = Store(tmp_path, gcode_lines, facts=job_facts.gcode_facts)
    settings = {100: "80", 101: "80", 102: "80", 110: "6000", 111: "6000", 112: "3000", 120: "500", 121: "500", 122: "300"}
    for name, text, said in (("sums.nc", "N1 G21*18\nN2 G0 X5*7\n", "checksums such as *18"), ("long.nc", "G21\nG1 X5 F1 " + "Y1.00000 " * 30, "the line has"), ("no.nc", "G21\n5\n", "")):
        (tmp_path / name).write_text(text)
        about = store.facts_of(name, settings)
        assert about["refused"] and about["advice"].startswith(said) and bool(about["advice"]) == bool(said), name
