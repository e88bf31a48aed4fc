"""Programs of LinuxCNC's own (tests/interp, nc_files), compiled, beside what its interpreter makes of them. Needs `rs274` (apt-get install
linuxcnc-uspace) and LINUXCNC, the folder of its sources; they are no part of Passo."""

import collections
import os
from pathlib import Path

import pytest

import rs274
from host_tools.failure import Failure
from host_tools.programs.compiler import compile_file

SOURCES = os.environ.get("LINUXCNC")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not rs274.RS274 or not SOURCES, reason="needs rs274 (apt-get install linuxcnc-uspace), and LINUXCNC to name its sources"),
]

# Taken, and not the same: why.
OTHERWISE = {
    "nc_files/skeleton.ngc": "rs274 alone raises Z by the tool's length at the next line",
    "nc_files/lathecomp.ngc": "another way in",
    "nc_files/useful-subroutines.ngc": "Z alone behind G40 moves X and Y there",
    "tests/interp/inside-corners/test.ngc": "another way in",
    "tests/interp/inverse-time-with-comp/inverse.ngc": "another way in",
    "tests/interp/g84/g18/g98/g18-g98-g84.ngc": "rs274 drills along X",
    "tests/interp/g84/g18/g99/g18-g99-g84.ngc": "rs274 drills along X",
    "tests/interp/g84/g19/g98/g19-g98-g84.ngc": "rs274 drills along Y",
    "tests/interp/g84/g19/g99/g19-g99-g84.ngc": "rs274 drills along Y",
}
# Compensation that LinuxCNC takes, and its own way out at the height of the cut crosses the contour.
GOUGES = {"nc_files/comp.ngc", "tests/interp/crazy-paths/test.ngc"}
ENDLESS = "nc_files/smartprobe.ngc"  # a menu that waits for its operator


def outcome(path, tables):
    """What becomes of a program: "equal", "refused" … and a text."""
    try:
        wanted = rs274.of_linuxcnc(path, tables[0])
    except ValueError:
        wanted = ()  # splines, whose points rs274 does not print
    if wanted is None:
        return "refused by both or by rs274", ""
    try:
        program = compile_file(path, "ngc", tables[1], (0, 0, 0), 100_000)
    except Failure as error:
        return ("nothing moves", "") if "does nothing" in str(error) and not wanted else ("refused", str(error))
    if wanted == ():
        return "spline", ""
    found = rs274.differs(wanted, rs274.of_board(program.listing.codes))
    return ("differs", found) if found else ("equal" if wanted else "nothing moves", "")


def test_programs_of_linuxcnc(tmp_path):
    rows = [(number, 0.05 * number, 0.1 * number) for number in range(1, 44)]
    tables = tmp_path / "inch.tbl", tmp_path / "mm.tbl"
    for table, scale in zip(tables, (1, 25.4)):  # rs274 alone takes a table for inches
        table.write_text("".join(f"T{number} P{number} D{wide * scale:.6f} Z{long * scale:.6f}\n" for number, wide, long in rows))
    found = collections.Counter()
    for path in sorted(path for folder in ("tests/interp", "nc_files") for path in (Path(SOURCES) / folder).rglob("*.ngc")):
        name = path.relative_to(SOURCES).as_posix()
        kind, text = outcome(path, tables) if name != ENDLESS else ("refused", "")
        found[kind] += 1
        if kind == "differs":
            assert name in OTHERWISE, (name, text)
        if kind == "refused":
            assert "error 34" not in text or name in GOUGES, (name, text)
            print(name, text)
    print(dict(found))
    assert found["equal"] >= 43 and found["refused"] <= 37 and found["differs"] <= len(OTHERWISE), found
