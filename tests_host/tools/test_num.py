"""The words of the shop's NUM table by examples, read by plain_reader.py, and each error by its line; pockets against shapely."""

import pytest
from shapely import LineString, Point, box, union_all

from host_tools.programs.listing import Listing
from host_tools.programs.num.interpreter import compile_program
from host_tools.programs.program_errors import ProgramError
from host_tools.programs.tool_table import Tool
from plain_reader import cut_points, events, same

TOOLS = {1: Tool(6.0), 2: Tool(4.0)}
ZERO = (0.0, 0.0, 0.0)


def compiled(text, start=ZERO, **options):
    listing = Listing()
    compile_program("p.num", text, listing, TOOLS, start, **options)
    return listing


# (program, the plain G-code that does the same from 0, 0, 0)
EXAMPLES = (
    ("%1\nN10 G00 X1 Y2 Z3", "G0 X1 Y2 Z3"),
    ("G01 X10 F100 (a line)\nY5\nG00 X0", "G1 X10 F100\nY5\nG0 X0"),
    ("G02 X10 Y0 I5 J0 F100", "G2 X10 Y0 I5 J0 F100"),
    ("G00 X10\nG03 X20 Y0 I15 J0 F100 Z4", "G0 X10\nG3 X20 Y0 Z4 I5 J0 F100"),
    ("G00 X10\nG91 G03 X10 I5 F100", "G0 X10\nG3 X20 Y0 I5 J0 F100"),
    ("G02 X10 Y0 R8 F100", "G2 X10 Y0 R8 F100"),
    ("G18 G02 X10 Z0 I5 K0 F100", "G18 G2 X10 Z0 I5 K0 F100"),
    ("G04 F1.5", "G4 P1.5"),
    ("G91 G00 X5\nX5\nG90 X5", "G0 X5\nX10\nX5"),
    ("G70 G01 X1 F10\nG71 X1", "G1 X25.4 F254\nX1"),
    ("G97 S1200 M03\nM04\nM05\nM08\nM09", "S1200 M3\nM4\nM5\nM8\nM9"),
    ("M10\nG00 X1\nM08 M11", "M10\nG0 X1\nM8\nM11"),
    ("T2 D2 M06", "M6 T2"),
    ("M00\nM01\nG00 X1\nM02\nG00 X9", "M0\nM1\nG0 X1\nM2"),
    ("G59 X10 Y20\nG00 X1 Y1 Z1\nG59 X0 Y0\nG00 X1 Y1", "G0 X11 Y21 Z1\nX1 Y1"),
    ("G59 X10\nG91 G59 X5\nG90 G00 X1", "G0 X16"),
    ("G59 X10 Y10\nG00 X0 Y0\nG02 X10 Y0 I5 J0 F100", "G0 X10 Y10\nG2 X20 Y10 I5 J0 F100"),
    ("G81 X5 Y5 Z-3 ER2 F60\nX10\nG80\nG00 X0", "G0 Z2\nG0 X5 Y5\nG1 Z-3 F60\nG0 Z2\nX10\nG1 Z-3\nG0 Z2\nX0"),
    ("G00 Z5\nG81 X5 Z-3 F60", "G0 Z5\nX5\nG1 Z-3 F60\nG0 Z5"),
    ("G00 Z5\nG91 G81 X5 Z-4 ER-3 F60\nX5", "G0 Z5\nX5\nZ2\nG1 Z-2 F60\nG0 Z2\nX10\nG1 Z-2\nG0 Z2"),
    ("L1=5\nG00 XL1 Y-L1 Z+L1", "G0 X5 Y-5 Z5"),
    ("L1=2*3+4\nL2=L1/4-1\nG00 XL1 YL2", "G0 X10 Y1.5"),
    ("L1=S30 L2=C60\nL3=A1\nL4=R16\nL5=T-2.7\nG00 XL1 YL2 ZL3\nXL4 YL5", "G0 X0.5 Y0.5 Z45\nX4 Y-2"),
    ("L1=3\nL1=L1-1 L2=L1\nG00 XL1 YL2", "G0 X2 Y3"),
    ("G79 N30\nN20 G00 X1\nN30 G00 Y1", "G0 Y1"),
    ("N10 L1=L1+1\nG00 XL1\nG79 L1<3 N10\nG00 Y1", "G0 X1\nX2\nX3\nY1"),
    ("L1=5\nG79 L1>=5&L2=0 N9\nG00 X1\nN9 G79 L1<>5!L1<=4 N10\nG00 Y1\nN10 G00 Z1", "G0 Y1\nZ1"),
    ("G77 H10 S2\nG00 X0\n%10\nG91 G00 X1\nG90", "G0 X1\nX2\nX0"),
    ("G91\nN10 G00 X1\nN20 Y1\nG77 N10 N20 S2\nG90 Z1", "G0 X1\nY1\nX2\nY2\nX3\nY3\nZ1"),
    ("N10 G00 X1\nG77 N10\nG00 X2\nG77 H7 N2 N3 S1\n%7\nN1 G00 Y1\nN2 G00 Y2\nN3 G00 Y3\nN4 G00 Y4", "G0 X1\nX2\nY2\nY3"),
    ("G77 H10\nM02\n%10\nG77 H20\nG00 X5\n%20\nG00 X3", "G0 X3\nX5\nM2"),
    ("/G00 X5\nG00 Y1", "G0 X5\nY1"),
    ("D1 G00 X-10\nG41 G01 X0 F100\nY20\nG40 G00 X-10", "G0 X-10\nG1 X-3 F100\nY20\nG0 X-10"),
    ("G00 X10\nG42 D2 G01 X0 F100\nY20\nX-20\nG40 G00 Y30", "G0 X10\nG1 X2 F100\nY20\nG3 X0 Y22 R2\nG1 X-20\nG0 Y30"),
    ("G09 G94 G00 X1", "G0 X1"),
)  # fmt: skip


@pytest.mark.parametrize("program, plain", EXAMPLES)
def test_words(program, plain):
    found, wanted = events(compiled(program).codes, ZERO), events(plain.split("\n"), ZERO)
    assert same(found, wanted), (found, wanted)


# (program, number of the error, line)
ERRORS = (
    ("G00 X", 300, 1), ("L1 5", 300, 1), ("\nL1=2+3*4", 300, 2), ("G79 L1 N10", 300, 1), ("%A", 300, 1), ("G00 X1,5", 300, 1),
    ("L1=" + "9" * 400, 304, 1), ("G00 X9999999", 316, 1), ("L1=1/L2", 303, 1), ("L1=R-4", 304, 1), ("L20=1", 305, 1), ("G00 XL50", 305, 1),
    ("G12", 310, 1), ("M33", 310, 1), ("G00 U1", 310, 1), ("G00 G01 X1", 312, 1), ("M03 M04", 312, 1), ("G00 X1 X2", 313, 1),
    ("G79", 314, 1), ("G77", 314, 1), ("G04", 314, 1), ("G59", 314, 1), ("G81 X1 F1", 314, 1), ("G45 X1 Z-1 D1 F1", 314, 1),
    ("G03 X0 Y0 I5 F1", 314, 1), ("G00 X1 P5", 315, 1), ("G00 X1 N5", 315, 1), ("G77 H1 X5\n%1\nG00 X1", 315, 1),
    ("G04 F100", 316, 1), ("G81 X1 Z3 ER2 F1", 316, 1), ("G02 X5 R-5 F1", 316, 1), ("T1.5", 317, 1), ("G77 H1 G00", 318, 1),
    ("G01 X1", 319, 1), ("G02 X10 Y0 I5 J0", 319, 1), ("G00 X10\nG02 X20 Y0 I5 J0 F1", 321, 2), ("G02 X9 F1", 321, 1),
    ("N1 G00\nN1 G00", 330, 2), ("%1\nG00\n%1", 330, 3), ("\nG77 H5", 332, 2), ("G77 H1\n%1\nG77 H1", 333, 3),
    ("N10 G79 N10", 334, 1), ("G79 N5", 335, 1), ("N2 G00\nN1 G00\nG77 N1 N2", 335, 3), ("G77 H1\nN9 G00\n%1\nG79 N9", 335, 4),
    ("G41 X5", 340, 1), ("D9 G41 X5", 340, 1), ("G45 X1 Z-1 EB5 F1", 340, 1),
    ("D1 G00 X-10\nG41 G01 X0 F1\nY10\nG03 X4 Y10 I2 J10\nG01 Y0\nG40", 343, 4),
    ("G00 X0 Y0 Z0\nG18 G41 D1 G01 X5 F9\nG17 G02 X9 I7 J0", 347, 3), ("D1 G41 G00 X5\nG59 X1", 347, 2), ("D1 G41 G00 X5\nG45 Z-1 EB9", 347, 2),
    ("G45 Z-1 EB2 D1 F1", 348, 1), ("G45 Z-1 EX20 EY10 EB6 D1 F1", 348, 1), ("G45 Z-1 EB9 Q5 D1 F1", 348, 1), ("G45 Z-1 EB9 P-1 D1 F1", 348, 1),
    ("G45 Z-1 EX20 EY20 EB2 D1 F1", 348, 1), ("G45 Z-1 EX-5 EB3 D1 F1", 348, 1),
)  # fmt: skip


@pytest.mark.parametrize("program, error, line", ERRORS)
def test_errors(program, error, line):
    with pytest.raises(ProgramError) as refusal:
        compiled(program, bound=1000)
    assert (refusal.value.number, refusal.value.place.line) == (error, line), str(refusal.value)


def test_a_place_that_nobody_knows():
    with pytest.raises(ProgramError) as refusal:
        compiled("G00 X1 Y1\nG81 Z-1 F5", (None, None, None))
    assert refusal.value.number == 320 and "Z" in str(refusal.value)


def rounded(x, y, width, height, corner):
    return box(x - width / 2 + corner, y - height / 2 + corner, x + width / 2 - corner, y + height / 2 - corner).buffer(corner, quad_segs=200)


POCKETS = (
    ("EX40 EY25 EB5 Q4 P2", 1, rounded(5, 7, 40, 25, 5)),
    ("EX40 EY25 Q4.2 P2", 1, rounded(5, 7, 40, 25, 3)),
    ("EX18 EY30 EB4 Q1.5 P5 G02", 2, rounded(5, 7, 18, 30, 4)),
    ("EB11 Q2.5 P1", 2, Point(5, 7).buffer(11, quad_segs=200)),
    ("EX40 EB8 Q3 P3", 1, rounded(5, 7, 40, 16, 8)),
    ("EY40 EB8 Q3 P3", 1, rounded(5, 7, 16, 40, 8)),
    ("EX40 EY25 EB5 Q4 P2 I0.5 J0.4 EP50 EQ200 EI40 EJ100", 1, rounded(5, 7, 40, 25, 5)),
    ("EB3 P5", 1, Point(5, 7).buffer(3, quad_segs=200)),
)  # fmt: skip


@pytest.mark.parametrize("words, tool, room", POCKETS)
def test_pockets(words, tool, room):
    """All of the pocket is cleared, on every layer, and nothing beside it; the tool never goes sideways rapidly below ER."""
    listing = compiled(f"G00 Z9\nG45 X5 Y7 Z-4.5 ER1 {words} D{tool} F300\nG80\nG00 X0 Y0")
    found = events(listing.codes, ZERO)
    radius = TOOLS[tool].radius
    layers, here = {}, ZERO
    for event in found:
        end = event[2] if event[0] == "feed" else event[4] if event[0] == "arc" else event[1]
        if event[0] == "rapid":
            assert end[:2] == here[:2] or min(end[2], here[2]) >= 1
        elif end[2] == here[2] or event[0] == "arc":
            points = cut_points([("rapid", here), event])[0]
            layers.setdefault(end[2], []).append(LineString(points).buffer(radius, quad_segs=100))
        else:
            layers.setdefault(end[2], []).append(Point(end[:2]).buffer(radius, quad_segs=100))
        here = end
    assert min(layers) == -4.5
    below = union_all(layers[-4.5])
    if "J" not in words:
        for level, cleared in layers.items():
            assert room.difference(union_all(cleared)).area < 0.02 * radius, level
    assert room.difference(below).buffer(-0.005).area < 0.01
    assert below.difference(room.buffer(0.01)).area < 0.001
    depth = [float(word[1:]) for word in words.split() if word[0] == "P"][0]
    levels = sorted({1.0, *layers}, reverse=True)
    assert all(high - low <= depth + 1e-9 for high, low in zip(levels, levels[1:]))
    feeds = {event[1] for event in found if event[0] != "rapid"}
    assert feeds == ({300.0} if "EP" not in words else {50.0, 200.0, 40.0, 100.0})


def test_pockets_one_after_the_other():
    """A cycle holds until G80: each further place is a pocket, or a hole."""
    listing = compiled("G00 Z5\nG45 X10 Y10 Z-1 ER1 EB4 D1 F60\nX30\nG80 G00 X0\nG81 X5 Z-1 ER1\nX8")
    found = events(listing.codes)
    down = [event[2][:2] for event in found if event[0] == "feed" and event[2][2] == -1.0]
    assert (10.0, 10.0) in down and (30.0, 10.0) in down and (5.0, 10.0) in down and (8.0, 10.0) in down
