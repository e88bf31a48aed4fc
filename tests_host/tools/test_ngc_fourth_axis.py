"""A of RS274/NGC: degrees, absolute in the listing; how F counts for it; which words refuse it. test_linuxcnc.py compares with LinuxCNC."""

import numpy
import pytest

import rs274
from host_tools import boards
from host_tools.cli.check import _check_file
from host_tools.cli.compile import _parse_start
from host_tools.drawings import gcode_file
from host_tools.failure import Failure
from host_tools.programs import compiler
from host_tools.programs.listing import Listing
from host_tools.programs.ngc.interpreter import compile_program
from host_tools.programs.num.interpreter import compile_program as compile_num
from host_tools.programs.program_errors import ProgramError
from host_tools.programs.tool_table import Tool

ZERO = (0.0, 0.0, 0.0, 0.0)


def compiled(text, start=ZERO, find=None, linear=False):
    listing = Listing()
    compile_program("p.ngc", text, listing, {1: Tool(6.0, 40.0)}, start, find=find, linear=linear)
    return listing


# (program, its listing from 0)
LISTINGS = (
    ("g0 x10 a90", ["G0 X10 A90"]),
    ("f600 g1 x10 a90\na180\nx20", ["G1 X10 A90 F600", "G1 A180", "G1 X20"]),
    ("g20\nf30\ng1 x1 a45\na10\nx1 a20\nx2", ["G1 X25.4 A45 F762", "G1 A10 F30", "G1 A20", "G1 X50.8 F762"]),
    ("f600\ng20\ng1 a90\nx1", ["G1 A90 F600", "G1 X25.4"]),
    ("g91 g0 a10\na10.5\ng90 a-5", ["G0 A10", "G0 A20.5", "G0 A-5"]),
    ("g91 g0 a180\na-180", ["G0 A180", "G0 A0"]),
    ("g91 g0 x1 a720\nf9 g1 x-1 a-180.001", ["G0 G91 X1 A720", "G90", "G1 G91 X-1 A-180.001 F9", "G90"]),
    ("g93 g1 x10 a90 f12\na0 f4\nx0 f6\ng94 f50 x1", ["G1 G93 X10 A90 F12", "G1 G94 A0 F360", "G1 X0 F60", "G1 X1 F50"]),
    ("g93 g1 x.001 a90 f2\ns5\ng4 p1\nx0 a0 f2\na9 f2\nm3", ["G1 G93 X0.001 A90 F2", "S5", "G4 P1", "G1 X0 A0 F2", "G1 G94 A9 F18", "M3"]),
    ("g93 g1 x.001 a90 f2\ng0 x5\ng2 x7 i1 f2", ["G1 G93 X0.001 A90 F2", "G0 X5", "G2 G94 X7 Y0 I1 J0 F6.283"]),
    ("g93 g1 x.001 a90 f2\nm3", ["G1 G93 X0.001 A90 F2", "G94", "M3"]),
    ("g93 g1 x.001 a90 f2\ng94\ng38.2 z-5 f9", ["G1 G93 X0.001 A90 F2", "G94", "G38.2 Z-5 F9"]),
    ("g93 g1 x.001 a90 f2", ["G1 G93 X0.001 A90 F2", "G94"]),
    ("m3 s100\ng95 g1 a90 f2\n", ["S100 M3", "G1 A90 F200"]),
    ("g20\ng92 a90 x1\ng1 a[#5423+1] x#5420 f1", ["G92 X25.4 A90", "G1 A91 F1"]),
    ("g20 g10 l2 p2 a30 z1\ng10 l20 p1 a5\ng0 a[#<_a>*2]", ["G10 L2 P2 Z25.4 A30", "G10 L20 P1 A5", "G0 A10"]),
    ("g10 l2 p2 a30\ng0 a10", ["G10 L2 P2 A30", "G0 A10"]),
    ("g28 a200\ng0 a1", ["G0 A200", "G91 G28 A0", "G90", "G0 A1"]),
    ("g91 g30 a-200", ["G0 G91 A-200", "G90", "G91 G30 A0", "G90"]),
    ("g20 f10\ng53 g1 a90\ng53 g0 a1 x1\ng53 g1 a5 x2", ["G53 G1 A90 F10", "G53 G0 X25.4 A1", "G53 G1 X50.8 A5 F254"]),
    ("g20 f10\ng38.2 a9\ng38.2 x1\ng90 g0 a0\ng91 g38.3 a-400", ["G38.2 A9 F10", "G38.2 X25.4 F254", "G0 A0", "G91 G38.3 A-400 F10", "G90"]),
    ("g10 l2 p1 r90\ng0 x1 a5\na7\ng91 g1 x1 a1 f9", ["G0 Y1 A5", "G0 A7", "G1 Y2 A8 F9"]),
    ("f9 m70\ng20 f10\nm72\ng1 a30", ["G1 A30 F9"]),
)  # fmt: skip


@pytest.mark.parametrize("text, codes", LISTINGS)
def test_listings(text, codes):
    listing = compiled(text)
    assert listing.codes == codes
    rs274.of_board(listing.codes)


ERRORS = (
    ("f1 g2 x2 i1 a1", 311), ("f1 g81 z-1 r1 a1", 311), ("f1 g81 z-1 r1 x1\na1", 311), ("g5 x1 i1 j1 p1 q1 f1 a5", 311), ("g5.1 x1 i1 j1 f1 a5", 311),
    ("g5.2 x1 y1 p1 f1 a5", 311), ("g0 b1", 310), ("g80\na5", 315), ("g0 x0 y0\ng41 d1\ng1 a5 f1", 347), ("g43.1 a5", 314), ("g0 a1 a2", 313),
    ("g0 a1e9", 315), ("g0 a9999999", 316), ("g0 x-9 y20\ng41 d1 g1 x0 y0 f1\nx20\nx30\ng40\ng93 x40.5 y3 a5 f1", 319), ("g93 g1 a9", 319), ("g1 a9", 319),
)  # fmt: skip


@pytest.mark.parametrize("text, number", ERRORS)
def test_errors(text, number):
    with pytest.raises(ProgramError) as refusal:
        compiled(text)
    assert refusal.value.number == number, str(refusal.value)


def test_where_a_stands_is_asked_for_and_told():
    for text in ("g91 g0 a1", "g0 a1\ng28\ng91 a1", "g0 a[#5423]", "g0 a1\ng54\ng55\ng91 g0 a1", "g0 a1\ng53 g0 a5\ng91 g0 a1", "g0 a1\ng38.2 a9 f1\ng91 g0 a1"):
        with pytest.raises(ProgramError) as refusal:
            compiled(text, ZERO[:3])
        assert refusal.value.number == 320 and ": A" in str(refusal.value)
    assert compiled("g91 g0 a1", _parse_start("0,0,5,30")).codes == ["G0 A31"]
    assert _parse_start("0,0,5") == (0, 0, 5)
    for text in ("1,2", "1,2,3,4,5", "1,2,3,a"):
        with pytest.raises(Failure, match="three numbers"):
            _parse_start(text)
    assert compiled("g0 a1\ng43 h1\ng91 a1", ()).codes == ["G0 A1", "G43.1 Z40", "G0 A2"]
    assert compiled("g93 g1 x0 a90 f4", ()).codes == ["G1 G93 X0 A90 F4", "G94"]


def test_beside_a_contour_and_in_it():
    """A word of A that turns nothing stands in a contour; behind it A turns, and the tool stays beside the contour."""
    codes = compiled("g0 x-9 y20\ng41 d1 g1 x0 y0 f9 a0\nx20\nx30\ng40\na90\nx40 y9 a80").codes
    assert codes[-2:] == ["G1 A90", "G1 X40 Y9 A80"] and not any("A" in code for code in codes[:-2])


def test_g93_keeps_its_time_where_next_to_nothing_moves_beside_a():
    """The residue of a CAM program's rounding in X would make a feed of nanometres a second."""
    rows = [f"x{0.00001 * (turn % 3 + 1):.5f} y{turn % 2 * 0.00004:.5f} a{7 * turn + 7} f{1 + turn % 5 * 0.5}" for turn in range(40)]
    path = rs274.of_board(compiled("g93 g1 " + "\n".join(rows)).codes)
    assert [time for _, _, time in path] == pytest.approx([1 / (1 + turn % 5 * 0.5) for turn in range(40)], rel=1e-6)


def test_g91_turns_as_far_as_it_says_on_a_board_that_takes_the_short_way():
    codes = compiled("g91 f600\ng0 a720\ng1 x5 a-1000\na180\na-179\ng90 a-5\ng91 g28 a400").codes
    ends = [rows[-1][3] - rows[0][3] for _, rows, _ in rs274.of_board(codes, short_way=True)]
    assert ends[:4] == pytest.approx([720, -1000, 180, -179]) and abs(ends[4]) <= 180 and ends[5] == pytest.approx(400)


def test_pictures_have_x_y_z_and_no_turns(tmp_path):
    listing = compiled("f100 g1 x1 a5\na10\nx2 a20\ng93 x2.0001 a30 f1\ng94 f9\na50\nz1")
    assert [len(point) for stroke in listing.strokes for point in stroke.points] == [3] * 8
    assert [stroke.source.line for stroke in listing.strokes] == [1, 3, 4, 7]
    path = tmp_path / "p.ngc"
    path.write_text("g0 x0 y0 z0 a0\nm3 s5\ng1 x9 a3 f9\na9\ny5\ng93 x9.0001 a3 f1\ng94 f9\nx0 y0\n")
    drawn = gcode_file.GcodeFile(path)
    assert [len(line) for lines in drawn._lines.values() for line in lines] == [5]


def test_num_keeps_three_axes():
    with pytest.raises(ProgramError):
        compile_num("p.num", "%1\nN10 G00 A5", Listing(), {}, ZERO)


# --- a linear A

LINEAR = (
    "g20 g0 x1 a2\ng1 a3 f10\nx2 a4\na5", "g20 f10\ng21\ng1 a5\ng20 a1\ng91 a.5\na-1 x1", "g20\ng92 a1\ng1 a2 f9\ng92.1\ng0 a1",
    "g20 g10 l2 p1 a1\ng0 a1\ng10 l20 p1 a3\ng0 a0", "g20 f10\ng53 g1 a2\ng53 g0 a1 x1\ng90 g0 x0 a0", "g20 f9\ng38.2 a1",
)  # fmt: skip


@pytest.mark.parametrize("text", LINEAR)
def test_a_linear_axis_counts_inches(text):
    """A program of plain words, compiled, leads a machine with a linear A where the words themselves lead it, as fast."""
    lines = ["g21 g90 f100 g0 x0 y0 z0 a0", *text.split("\n")]
    listing = compiled("\n".join(lines), linear=True)
    wanted, found = (rs274.of_board(codes, linear=True) for codes in ([line.upper() for line in lines], listing.codes))
    wanted, found = ([(*rows[-1], time or 0) for _, rows, time in path if abs(rows[-1] - rows[0]).max() > 1e-6] for path in (wanted, found))
    assert numpy.array(found) == pytest.approx(numpy.array(wanted), abs=1e-3)
    assert compiled("\n".join(lines)).turns_in_inches and not listing.turns_in_inches


def test_the_machine_says_whether_a_is_linear(tmp_path, monkeypatch, capsys):
    file = tmp_path / "a.ngc"
    file.write_text("g20 g90 f60\n#1=2\ng0 x0 y0 z0 a0\ng1 a#1\nm2\n")
    program = compiler.read(file)
    assert "G1 A2 F60" in program.listing.codes
    assert compiler.fit_to_machine(program, ["[VER:1.1h.20190830:]", "[AXS:4:XYZA]", "[ROTARY:A]"]) is program
    assert compiler.fit_to_machine(program, ["[VER:1.1h.20190830:]"]) is program
    assert "G1 A50.8 F1524" in compiler.fit_to_machine(program, ["[AXS:4:XYZA]"]).listing.codes
    board = boards.load("router_4axis")
    del board["rotary"]
    path = tmp_path / "linear.py"
    path.write_text(f"BOARD = {board!r}\n")
    for name, length in (("router_4axis", 2.0), (str(path), 50.8)):
        _check_file(file, name, ((), None, None), None, None, None)
        assert [float(line.split()[3]) for line in capsys.readouterr().out.splitlines() if line[0] == "A"] == [pytest.approx(length, abs=0.02)]
