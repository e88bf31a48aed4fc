"""Programs, compiled, beside what LinuxCNC's interpreter makes of them. Needs `rs274` (apt-get install linuxcnc-uspace); for programs of
LinuxCNC's own (tests/interp, nc_files) LINUXCNC, the folder of its sources, too. They are no part of Passo."""

import collections
import os
from pathlib import Path

import pytest

import rs274
from host_tools.failure import Failure
from host_tools.programs.compiler import compile_file

SOURCES = os.environ.get("LINUXCNC")
pytestmark = [pytest.mark.slow, pytest.mark.skipif(not rs274.RS274, reason="needs rs274 (apt-get install linuxcnc-uspace)")]

# Taken, and not the same: why.
OTHERWISE = {
    "nc_files/skeleton.ngc": "rs274 alone raises Z by the tool's length at the next line",
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


@pytest.mark.skipif(not SOURCES, reason="LINUXCNC is to name LinuxCNC's sources")
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


# Programs that keep their modal state, or lose it.
KEPT = (
    "g21 g90 f100\ng0 x0 y0 z0\ng91 m70\ng90\ng1 x1\nm72\ng1 x2\nm2",
    "o<s> sub\nm73\ng20 g91 f10 g18 g99\ng1 x1\no<s> endsub\ng21 g90 f100 g0 x0 y0 z0\ng1 x9\no<s> call\ng1 x20\ng2 x22 y0 i1\nm2",
    "g21 g90 f100 g0 x0 y0 z0\ng1 x10\nm98 p100 l3\ng1 x20\nm2\no100\nm73\ng91 g1 y1\nm99",
    "g21 g90 f100 g0 x0 y0 z0\no1 sub\nm73\ng91\ng1 x1\nm71\no1 endsub\no1 call\ng1 x5\nm2",
    "g21 g90 f100 g0 x0 y0 z0\no1 sub\nm73\ng91\no2 call\ng1 x1\no1 endsub\no2 sub\nm73\ng90\ng1 y7\no2 endsub\no1 call\ng1 x5\nm2",
    "g21 g90 f100 g0 x0 y0 z0\ng49\nm70\ng43.1 z5\ng0 z1\nm72\ng0 z2 x3\nm2",
    "g21 g90 f100 g0 x0 y0 z0\ng10 l2 p2 x5 y6 z0\nm70\ng55\ng0 x1 y1\nm72\ng0 x2 y3 z4\nm2",
    "g21 g90 f100 g0 x0 y0 z0\nm70 g91.1\ng90.1\nm72\ng2 x2 y0 i1 j0\nm72\ng1 x9\nm2",
    "g21 g90 f100\nm72\nm2",
    "g21 g90 f100\nm70\nm71\nm72\nm2",
    "g21 g90 f100\nm70\no1 call\nm2\no1 sub\nm72\no1 endsub",
)


@pytest.mark.parametrize("text", KEPT)
def test_modal_state_is_kept_as_in_linuxcnc(tmp_path, text):
    path = tmp_path / "p.ngc"
    path.write_text(text + "\n")
    wanted = rs274.of_linuxcnc(path)
    if wanted is None:
        with pytest.raises(Failure, match="error 323"):
            compile_file(path, "ngc", None, (0, 0, 0), 1000)
        return
    found = rs274.of_board(compile_file(path, "ngc", None, (0, 0, 0), 1000).listing.codes)
    assert len(wanted) > 2 and rs274.differs(wanted, found) == ""
