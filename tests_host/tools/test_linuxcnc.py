"""Programs, compiled, beside what LinuxCNC's interpreter makes of them. Needs `rs274` (apt-get install linuxcnc-uspace); for programs of
LinuxCNC's own (tests/interp, nc_files) LINUXCNC, the folder of its sources, too. They are no part of Passo."""

import collections
import os
import random
from pathlib import Path

import numpy as np
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
    """Return what becomes of a program: "equal", "refused" … and a text."""
    try:
        wanted = rs274.of_linuxcnc(path, tables[0])
    except ValueError:
        wanted = ()  # splines, whose points rs274 does not print
    if wanted is None:
        return "refused by both or by rs274", ""
    try:
        program = compile_file(path, "ngc", tables[1], (0, 0, 0, 0), 100_000)
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
    assert found["equal"] >= 46 and found["refused"] <= 34 and found["differs"] <= len(OTHERWISE), found


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


# --- A, the fourth axis

FOUR = "g21 g90 f600 g0 x0 y0 z0 a0\n"
TURNED = (
    "g1 x10 a90\na180 f3600\nx0 y5 z-1 a-45.5\na-45.5\ng0 a720 x3",
    "g91 g1 x10 a400\na-30\ng0 a-800\nz1 a0.25\ng90 a7",
    "g20\nf30\ng1 x1 a90\na10\ng91 a10\nx.5\na10 z.25",
    "f600\ng20\ng1 a90\nx1\na80",  # F stands in degrees as it was typed
    "g1 a90\ng92 a0\na45\ng92 x1 a[#5423*2]\ng1 a#5423 x5\na#<_a> x9\ng92.1\ng0 x1 y1 z1 a1\na9",
    "g10 l2 p1 a30\ng0 x1 y1 z1 a10\ng10 l2 p2 x5 a-20\ng55 g0 x1 y1 z1 a10\ng91 a5\ng90 g54 a10\ng10 l20 p1 a3\ng1 a4",
    "g20 g10 l2 p1 a30 x1\ng0 x1 y1 z1 a10\ng92 a5 x1\ng0 a6\n",
    "g1 a50 x9\ng28 a200\ng0 x1 y1 z1 a10\ng91 g28 a-300 x1\ng90 g0 x1 y1 z1 a10\ng30 z5 a5\ng0 a3 z1\ng28.1\ng0 a9\ng28 a1",
    "g53 g0 a77\ng0 a1\ng53 g1 a5 x7\ng0 a1 x0",
    "g93 g1 x10 a90 f12\na0 f4\nx0 f6\ng91 x1 y1 a10 f2\ng20 x1 a10 f2\na-10 f2\ng90 a3 x3 f1\ng94 f100\ng1 x0 a0",
    "g93 g1 x0 a90 f12\nx0 y0 z0 a9 f3\ng94 f50 x0 y0 a12",  # words of X that move nothing
    "o1 sub\ng91 g1 a#1 x#2\ng90\no1 endsub\no1 call [30] [2]\no2 repeat [3]\no1 call [#5423] [0]\no2 endrepeat\no3 while [#<_a> gt 0]\ng0 a[#<_a>-100]\no3 endwhile",
    "f100 m70\ng93 g91 g1 a9 f2\nm72\ng1 a20\nf200 m70\ng20 f10\nm72\na30\nx3",
    "g10 l2 p1 r30\ng0 x10 y0 z0 a20\ng1 x20 a30\na40\ng91 y5 a1\nz1 a400",
    "g2 x10 i5\ng1 a90\ng3 x0 i-5 z1\ng81 x3 z-1 r1\ng80\ng0 a3",
    "g38.2 x5 a40 f50",
    "a5",
)


def timed(path):
    """Minutes of each line that F counts for, as far as it moves."""
    return [time for rapid, rows, time in path if not rapid and time is not None and abs(rows[-1] - rows[0]).max() > 1e-3]


def goes_as_linuxcnc(folder, text):
    path = folder / "p.ngc"
    path.write_text(text + "\nm2\n")
    wanted = rs274.of_linuxcnc(path)
    assert wanted, text
    found = rs274.of_board(compile_file(path, "ngc", None, None, 1000).listing.codes)
    assert rs274.differs(wanted, found) == "", text
    assert np.allclose(timed(found), timed(wanted), rtol=0.01), (text, timed(wanted), timed(found))
    return len(wanted)


@pytest.mark.parametrize("text", TURNED)
def test_the_fourth_axis_goes_as_in_linuxcnc(tmp_path, text):
    assert goes_as_linuxcnc(tmp_path, FOUR + text) > 1


class Turning:
    """A random program of four axes."""

    def __init__(self, seed):
        self.draw = random.Random(seed)
        self.inches = self.relative = self.inverse = False
        self.rows = [FOUR + "o1 sub\ng91 g1 a#1 x#2 f#3\ng90\no1 endsub"]

    def word(self, letter):
        if letter == "a":
            return f"a{self.draw.choice((self.draw.randint(-40, 40), self.draw.randint(-900, 900), self.draw.randint(-9000, 9000) / 10))}"
        return f"{letter}{self.draw.randint(-30, 30) / (10 if self.inches else 2)}"

    def words(self, letters="xyza"):
        return " ".join(self.word(letter) for letter in self.draw.sample(letters, self.draw.randint(1, len(letters))))

    def known(self):
        """Everything is where the program says, after a line that moves or counts from elsewhere."""
        self.relative = False
        self.rows.append("g90 g0 " + " ".join(map(self.word, "xyza")))

    def line(self):
        draw = self.draw
        kind = draw.randrange(20)
        if kind < 11:
            feed = f" f{draw.randint(1, 40) / 2}" if self.inverse else draw.choice(("", "", f" f{draw.randint(20, 4000)}"))
            rapid = draw.random() < 0.2
            letters = draw.choice(("xyza", "xyza", "a", "xa", "xyz"))
            self.rows.append(f"g0 {self.words(letters)}" if rapid else f"g1 {self.words(letters)}{feed}")
        elif kind == 11:
            self.relative = not self.relative
            self.rows.append(f"g{91 if self.relative else 90}")
        elif kind == 12:
            self.inches = not self.inches
            self.rows.append(f"g{20 if self.inches else 21}")
        elif kind == 13:
            self.inverse = not self.inverse
            self.rows.append("g93" if self.inverse else f"g94 f{draw.randint(20, 4000)}")
        elif kind == 14:
            self.rows.append(f"o1 call [{draw.randint(-400, 400)}] [{draw.randint(-4, 4)}] [{draw.randint(1, 30)}]")
            self.relative = False
        elif kind == 15:
            self.rows.append(f"#{draw.randint(31, 33)}=#5423")
            self.rows.append(f"g0 a[#{draw.randint(31, 33)}/2+#<_a>/4]")
        elif kind == 16:
            self.rows.append(f"g92 {self.words('xa')}")
        else:
            self.rows.append(
                draw.choice((
                    "g92.1", "g54", "g55", f"g90 g53 g0 {self.words('xa')}", f"g{draw.choice((28, 30))} {self.words('xa')}", f"g10 l2 p1 {self.words('za')}",
                    f"g10 l2 p2 {self.words('xa')}", f"g10 l20 p1 {self.words('ya')}",
                ))  # fmt: skip
            )
            self.known()


def test_random_programs_of_four_axes_go_as_in_linuxcnc(tmp_path):
    moves = 0
    for seed in range(300):
        program = Turning(seed)
        for _ in range(30):
            program.line()
        folder = tmp_path / str(seed)
        folder.mkdir()
        moves += goes_as_linuxcnc(folder, "\n".join(program.rows))
    assert moves > 4000
