"""Programs of every word of docs/reference/gcode.md, as a board reads them, beside LinuxCNC's interpreter: the same path, or a refusal in
words. docs/reference/cycles.md lists the differences. Needs `rs274` (apt-get install linuxcnc-uspace)."""

import random
import re

import pytest

import rs274
from host_tools.options import error_texts
from host_tools.resources import ROOT

pytestmark = pytest.mark.skipif(not rs274.RS274, reason="needs rs274 (apt-get install linuxcnc-uspace)")
BEGIN = "G21 G90 G17 G94 G98"
TABLE = "".join(f"T{number} P{number} D6 Z0\n" for number in range(1, 10))

# Lines are parted by " | ".
SAME = (
    "G0 X5 Y-2 Z3 | X1", "G1 X5 F300 | Y2.5 Z-1 | X0 Y0", "G1 X+5 F100.5 | X.5 | X-.5 | X 1 . 2 | X00012.500", "g0x1y2 | g01z-1f50",
    "N10 G0 X1 | N20 X2 (comment) Y1 ; end | /X3 | G1 X4 F100", "G0 X1 | G80 | G1 X2 F50 | G80 | G0 X3",
    "G2 X4 Y0 I2 J0 F200 | G3 X0 Y0 I-2 | G2 X2 Y2 R2 | G3 X4 Y0 R-2 | G2 X4 Y0 I1 P3 | G3 I2 J0 P2 X4 Y0",
    "G2 X4 Y0 Z-2 I2 J0 F200 | G3 X0 Y0 Z1 I-2 P2", "G91 G2 X2 Y0 I1 F100 | G3 X-2 I-1 Z1", "G1 X1 F100 | G2 X1 I2", "G2 X10 Y0 R4.9999 F100",
    "G18 G2 X2 Z-2 K-2 F100 | G3 X0 Z0 R2 | G2 X3 Y2 Z0 I1.5", "G19 G2 Y2 Z-2 K-2 F100 | G3 Y0 Z0 R2 | G3 X2 Y3 Z0 J1.5",
    "G20 G2 X1 Y1 I1 J0 F10 | G18 G3 X0 Z0 I-.5", "G3 X0.0001 Y0 I5 F100", "G1 F100 X1 | G2 Y2 J1 | G3 X3 I1 Y2",
    "G4 P0.2 | G0 X1 | G4 P0 X2", "G10 L2 P1 X1 Y2 Z3 | G0 X0 Y0 Z0 | G10 L20 P1 X5 Y5 | G0 X0 Y0 | G10 L2 P0 X9 | X1",
    "G91 G10 L2 P1 X1 | G90 G0 X0", "G10 L20 P2 X5 | G55 G0 X0 | G10 L20 P0 Y3 | G0 Y0", "G10 L1 P1 Z4 | G43 H1 | G0 Z1 | G49 | G0 Z1",
    "G55 G0 X1 | G10 L2 P2 X4 Z1 | X1 Z0 | G54 X1 | G56 X1 | G57 X1 | G58 X1 | G59 X1 Z9", "G20 G0 X1 Y0.5 | G1 X2 F10 | G21 X10 | X20 F300",
    "G0 X5 Y5 Z5 | G28.1 | X0 Y0 Z0 | G28 | X1 Y1 | G28 X2 | G91 G28 Z0 | G90 | G30 Z6 | G30.1 | X0 | G30 Y1",
    "G38.2 X5 F100 | G38.3 X6 | G38.4 X7 | G38.5 X8", "G40 G61 G1 X1 F100 | G61.1 X2 | G64 X3 | G64 P0.1 Q0.1 X4 | G91.1 X5",
    "G43.1 Z2 | G0 Z1 | G49 | Z1 | G43.1 Z-1.5 | G91 Z1 | G90 Z0", "G53 G0 X1 Y1 | G10 L2 P1 X5 | G53 G0 X1 Z2 | G53 G1 Y3 F100 | G1 X0",
    "G91 G0 X1 | X2 Y1 | G1 X1 F100 | G90 X0", "G92 X5 Y1 | G0 X0 Y0 | G92 Z3 | Z0 | G92.1 | X0 Y0 Z0 | G92 X1 | G54 X0 | G55 X0",
    "G92 X1 | G10 L2 P1 X2 | G0 X0 | G92.1 | G0 X1", "G93 G1 X10 F2 | Y10 F4 | G94 F100 X0 | G93 G2 X2 I1 F1",
    "M0 | G0 X1 | M1 | G0 X2 | T3 M6 | G0 X3", "M3 S1000 | G1 X2 F100 | M4 S2000 X3 | M5 X4", "M7 | M8 | G0 X1 | M9 | G0 X2",
    "M62 P1 | G1 X2 F100 | M63 P1 | X3 | M64 P2 | M65 P2 | X4", "M66 P0 L0 | G0 X1 | M66 P1 L3 Q1 | G0 X2", "G91 G1 X1 F100 | M30", "G0 X1 | M2",
    "G0 A5 | G1 A10 F100 | X2 A3",
    "G0 Z5 | G81 X1 Y1 Z-2 R1 F100 | X3 | X5 Z-3 R2 | G80 | G0 X0", "G0 Z5 | G99 G82 X1 Z-2 R1 P0.1 F100 | X3 P0.2 | G80",
    "G0 Z5 | G99 G83 X1 Z-5 R1 Q1.5 F100 | G98 X2 | Q2 X4", "G0 Z5 | G73 X1 Z-5 R1 Q1.5 F100 | X2", "G0 Z5 | G81 X1 Z-2 R1 F100 L3",
    "G0 Z5 | G91 G81 X1 Y2 Z-3 R-4 F100 L4 | G90 G80 | G0 X0", "G81 X1 Z-2 R1 F100 | X2 | R2 X3 | X4",
    "G0 Z5 | G81 Z-2 R1 F100 | Y4 | G81 Z-3 R1 | G0 X9 | G81 X8 Z-1 R0",
    "G0 Z5 | G99 G81 X1 Z-2 R1 F100 | G92 X0 Z5 | X2", "G0 Z5 | G81 X1 Z-2 R1 F100 | G4 P0.1 | M8 | X2 | G53 G0 Z7 | G81 X3 Z-2 R1",
    # the height before the series, whatever is within it
    "G0 Z8 | G99 G81 X1 Z-4 R1 F400 | X2 | G98 X3 | G0 X20", "G0 Z8 | G99 G81 X1 Z-4 R1 F400 | G98 | X3", "G0 Z8 | G99 G73 X1 Z-4 R1 Q2 F400 | G98 X3",
    "G0 Z8 | G91 G99 G81 X1 Z-5 R-7 F400 | X1 | G98 X1", "G0 Z8 | G99 G83 X1 Z-4 R1 Q2 F400 | G98 G81 X2 Z-3 R1 | G73 X4 Z-2 R1 Q1",
    "G0 Z8 | G99 G81 X1 Z-4 R1 F400 | X2 | R12 X3 | G98 X4 R3", "G0 Z8 | G99 G81 X1 Z-4 R1 F400 | M6 T1 | X2 | G98 X3",
    "G0 Z8 | G99 G81 X1 Z-4 R1 F400 | G92 Z10 | X2 | G98 X3", "G0 Z8 | G99 G81 X1 Z-4 R1 F400 | G80 | G98 G81 X3 Z-4 R1",
    "G0 Z8 | G99 G81 X1 Z-4 R1 F400 | G91 G98 X3 L3 R-7 Z-5",
)  # fmt: skip

# Programs that both accept and carry out differently: the reason, as the table of cycles.md has it.
OTHERWISE = {
    "G99 | G0 Z5 | G99 G81 X1 Z-2 R1 F100 | G43.1 Z1 | X2": "a line of a series begins below its R",
    "G0 Z8 | G91 G99 G81 X1 Z-4 R-7 F400 | X1 R-5": "a line of a series begins below its R",
    "G81 X1 Z-4 R3 F100 | X4 R2": "a lower R within a series",
    "G0 Z8 | G99 G81 X1 Z-4 R1 F400 | G28 Z9 | G98 X3": "G28 between two lines of a series",
    "G0 X1 | M2 | G0 X2": "lines behind M2 or M30",
    "G0 Z5 | G20 G81 X1 Z-0.1 R0.1 F5 | G21 X30 Z-1 R1": "G20 or G21 within a series",
    "G43.1 Z1.5 | G20 G30 Z0.1": "G20 or G21 while a tool has a length",
    "G0 Z13.7 | G83 X0.6 Z-0.4 R2.5 Q2.9 F100": "a depth of a whole number of Q",
}
UNSAID = "G0 Z5 | G81 X1 Z-2 R1 F100"  # neither G98 nor G99
# Taken by the board alone.
TAKEN = {
    "G17 G3 X-2 Y2 I-2 F100 K1": "K of an arc in XY", "G0 Z5 | G93 G81 X1 Z-2 R1 F3": "a cycle in G93", "G43 H200": "G43 H of a tool",
    "G91 G53 G0 X3": "G53 in G91", "G28.1 X1": "G28.1 and G30.1 with axis words",
}  # fmt: skip
OWN = ("G3 I-5 H90 F100", "S0:500:1000", "S=@@OT_H", "M10 | M11")  # Passo's own words
# Refused by the board, by this error; [1]: by rs274, too.
REFUSED = {
    "G1 X1": (22, 1), "G2 X1 Y1 F100": (35, 1), "G1 X1 Y1 K2 F100": (36, 1), "G0 X1 X2": (25, 1), "G0 G1 X1": (24, 1), "G1 X2 F0": (22, 1), "G41 X1": (20, 1),
    "G2 X1 Y1 R0.1 F9": (34, 1), "G38.2 X0 F100": (33, 1), "G53 G2 X1 I1 F9": (30, 1), "T300": (38, 1), "G4 X1": (28, 1), "G92": (26, 1), "M3 S-1": (4, 1),
    "F-1": (4, 1), "N-1 G0 X1": (4, 1), "G1 X3 L2 F9": (36, 1), "G17 G18 X1": (21, 1), "G20 G21 X1": (21, 1), "G61 P1": (36, 1), "G81 X1 Z2 R1 F100": (33, 1),
    "G81 X1 R1 F100": (28, 1), "G83 X1 R1 Z-1 F100": (28, 1), "G80 X1": (31, 1), "G2 X2 R1 K0 F100": (36, 1),
    "G10 L2 P7 X1": (29, 0), "G59.1 G0 X1": (29, 0), "G2 X5 Y5 I5.02 J0 F100": (33, 0), "G90.1 G2 X2 Y2 I2 J0 F100": (20, 0), "G2 X10 Y0 R4.999 F100": (34, 0),
    "G64 P-1": (4, 0), "G10 L2 P1 R30": (26, 0), "G92.2": (20, 0), "G0 Z5 | G18 G81 X1 Y2 Z-2 R6 F100": (20, 0), "G0 Z5 | G19 G81 X1 Y2 Z-2 R6 F100": (20, 0),
    "G0 Z5 | G81 X1 Z-2 R1 F100 | G91 X2": (28, 0), "G0 Z5 | G81 X1 Z-2 R1 F100 | G20 X2": (28, 0), "G0 Z5 | M3 S100 | G84 X1 Z-2 R1 F100": (20, 0),
}  # fmt: skip


def paths(folder, text, begin=BEGIN):
    """(rs274's path, the board's) of a program; None: refused. The board's refusal is an error's number."""
    lines = [begin, *text.split(" | ")]
    (folder / "p.ngc").write_text("\n".join([*lines, "M2", ""]))
    (folder / "t.tbl").write_text(TABLE)
    for kept in folder.glob("*.var*"):
        kept.unlink()
    try:
        found = rs274.of_board(lines)
    except ValueError as refused:
        found = int(str(refused).rpartition(" ")[2])
    return rs274.of_linuxcnc(folder / "p.ngc", folder / "t.tbl"), found


@pytest.mark.parametrize("text", SAME)
def test_the_same_path(tmp_path, text):
    wanted, found = paths(tmp_path, text)
    assert wanted is not None and isinstance(found, list), (text, found)
    assert rs274.differs(wanted, found) == "", text


def table():
    return (ROOT / "docs" / "reference" / "cycles.md").read_text(encoding="utf-8").partition("## What differs")[2]


def test_what_differs_is_listed(tmp_path):
    rows = table()
    for text, row in [*OTHERWISE.items(), (UNSAID, "a cycle without G98 or G99")]:
        wanted, found = paths(tmp_path, text, BEGIN if text != UNSAID else BEGIN.removesuffix(" G98"))
        assert wanted and isinstance(found, list) and rs274.differs(wanted, found), text
        assert f"| {row}" in rows, row
    for text, row in TAKEN.items():
        wanted, found = paths(tmp_path, text)
        assert wanted is None and isinstance(found, list), text
        assert f"| {row}" in rows, row


def test_what_is_refused_is_told(tmp_path):
    for text, (error, both) in REFUSED.items():
        wanted, found = paths(tmp_path, text)
        assert found == error and error in error_texts() and (wanted is None) == both, (text, wanted, found)


def test_every_word_of_the_page_is_tried():
    page = (ROOT / "docs" / "reference" / "gcode.md").read_text(encoding="utf-8")
    rows = [row.split("|")[1] for row in page.partition("## Codes")[2].partition("\nLetters:")[0].splitlines() if row.startswith("| ")][2:]
    tried = " ".join([*SAME, *OTHERWISE, *TAKEN, *OWN]).upper()
    words = {word for row in rows for word in re.findall(r"[A-Z]\d*(?:\.\d)?", row)}
    words |= set(re.search(r"Letters: ([A-Z ]+)\.", page)[1].split())
    assert len(words) > 60
    missing = {word for word in words if not re.search(rf"{re.escape(word[0])}0*{re.escape(word[1:])}" + (r"(?![.\d])" if word[1:] else r"[-+. ]*[\d#=]"), tried)}
    assert not missing


class Plain:
    """A random program of plain words, in three axes."""

    def __init__(self, seed):
        self.draw = random.Random(seed)
        self.rows = ["G0 X0 Y0 Z9 F500"]
        self.inches = self.relative = False
        self.plane = 17

    def number(self, least, most):
        """Millimetres, or as many 25ths of them as inches."""
        value = self.draw.randint(round(least * 10), round(most * 10)) / 10
        return f"{value / 25:g}" if self.inches else f"{value:g}"

    def words(self, letters="XYZ"):
        return " ".join(letter + self.number(-9, 9) for letter in self.draw.sample(letters, self.draw.randint(1, len(letters))))

    def series(self):
        """A series of holes: of any cycle, G98 and G99 among them; R is never lowered and the tool never below it."""
        draw = self.draw
        self.rows.append("G90 G17 G0 Z" + self.number(12, 15))
        self.plane, self.relative = 17, draw.random() < 0.3
        code = draw.choice((73, 81, 82, 83))
        above, bottom = (self.number(-9, -8), self.number(-6, -1)) if self.relative else (self.number(1, 4), self.number(-6, 0))
        pecks = " Q" + draw.choice(("0.0537", "0.0911") if self.inches else ("1.337", "2.411"))  # no part of a depth
        more = {73: pecks, 83: pecks, 82: " P0.1"}.get(code, "")
        mode = draw.choice(("G98 ", "G99 ", ""))
        self.rows.append(f"G{91 if self.relative else 90} {mode}G{code} {self.words('XY')} Z{bottom} R{above}{more}")
        for _ in range(draw.randint(0, 5)):
            times = f" L{draw.randint(1, 4)}" if self.relative and draw.random() < 0.3 else ""
            self.rows.append(draw.choice(("G98", "G99", "M8", "G4 P0.1", "")) or "G98 " + self.words("XY") + times)
            self.rows.append(draw.choice(("G98 ", "G99 ", "", "")) + self.words("XY") + times)
        self.rows.append("G80")

    def arc(self):
        """A quarter, half or whole turn, or a helix, in relative places."""
        draw = self.draw
        first, second, third = {17: "XYZ", 18: "ZXY", 19: "YZX"}[self.plane]
        by, unit = draw.randint(1, 40) / 8, 25.0 if self.inches else 1.0
        whole = () if self.inches else ((0, 0, 1, 0),)  # the four decimals of inches that rs274 prints do not close a circle
        ends = draw.choice(((2, 0, 1, 0), (1, 1, 1, 0), (1, 1, 0, 1), (0, 2, 0, 1), *whole))
        clockwise = draw.choice((2, 3))
        if ends[:2] == (1, 1):
            clockwise = 2 if ends[2:] == (1, 0) else 3
        centre = dict(zip("XYZ", "IJK"))
        text = f"G91 G{clockwise} {first}{ends[0] * by / unit:.5f} {second}{ends[1] * by / unit:.5f} "
        text += f"{centre[first]}{ends[2] * by / unit:.5f} {centre[second]}{ends[3] * by / unit:.5f}"
        self.rows += [text + draw.choice(("", "", f" {third}{self.number(-3, 3)}", " P2")), f"G{91 if self.relative else 90}"]

    def line(self):
        draw = self.draw
        kind = draw.randrange(16)
        if kind < 6:
            self.rows.append(draw.choice(("G0 ", "G1 ", f"G1 F{draw.randint(50, 2000)} ")) + self.words())
        elif kind < 8:
            self.arc()
        elif kind < 10:
            self.series()
        elif kind == 10:
            self.relative = not self.relative
            self.rows.append(f"G{91 if self.relative else 90}")
        elif kind == 11:
            self.inches = not self.inches
            self.rows += ["G49", f"G{20 if self.inches else 21} F{draw.randint(10, 900)}"]  # see "G20 while a tool has a length"
        elif kind == 12:
            self.plane = draw.choice((17, 18, 19))
            self.rows.append(f"G{self.plane}")
        else:
            self.rows.append(draw.choice((
                "G92 " + self.words(), "G92.1", f"G{draw.randint(54, 59)}", f"G10 L2 P{draw.randint(0, 6)} " + self.words(), f"G10 L20 P{draw.randint(0, 6)} " + self.words(),
                "G90 G53 G0 " + self.words(), f"G{draw.choice((28, 30))} " + self.words(), f"G{draw.choice((28, 30))}.1", "G43.1 Z" + self.number(-3, 3), "G49",
                f"G93 G1 {self.words()} F{draw.randint(1, 9)}", "T2 M6",
            )))  # fmt: skip
            self.rows.append(f"G94 F300 G{91 if self.relative else 90}")


def test_random_programs(tmp_path):
    moves = 0
    for seed in range(120):
        program = Plain(seed)
        for _ in range(25):
            program.line()
        text = " | ".join(program.rows)
        wanted, found = paths(tmp_path, text)
        assert wanted is not None and isinstance(found, list), (seed, text.split(" | "), found)
        assert rs274.differs(wanted, found) == "", (seed, text.split(" | "))
        moves += len(wanted)
    assert moves > 3000
