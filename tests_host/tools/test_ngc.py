"""Every word of RS274/NGC by an example: plain_reader.py reads the listing, whose motion must be that of the plain lines beside it."""

import math
import random

import numpy as np
import pytest
from shapely import LineString

from host_tools.failure import Failure
from host_tools.programs.listing import Listing
from host_tools.programs.ngc import codes
from host_tools.programs.ngc.interpreter import compile_program
from host_tools.programs.program_errors import TEXTS, ProgramError
from host_tools.programs.tool_table import Tool
from plain_reader import events, same

TOOLS = {1: Tool(6.0, 40.0), 2: Tool(4.0, 55.5)}
ZERO = (0.0, 0.0, 0.0)


def compiled(text, **options):
    listing = Listing(options.pop("most", 100_000))
    options.setdefault("start", ZERO)
    compile_program("p.ngc", text, listing, dict(TOOLS), **options)
    return listing


# (program, the plain G-code that does the same from 0, 0, 0)
EXAMPLES = (
    ("g0 x1 y2 z3", "G0 X1 Y2 Z3"),
    ("g 0 X 1 . 5 (a comment) y2 ; and another", "G0 X1.5 Y2"),
    ("n10 g1 f100 x1\nn20 y1\n/ x5", "G1 X1 F100\nY1\nX5"),
    ("g1 x1 f100\nf200 x2", "G1 X1 F100\nX2 F200"),
    ("g20 g1 x1 f10\ng21 x1", "G1 X25.4 F254\nX1"),
    ("g91 g0 x1\nx1\ng90 x1", "G0 X1\nX2\nX1"),
    ("f100 g2 x2 y0 i1", "G2 X2 Y0 I1 J0 F100"),
    ("f100 g3 x2 y0 i1 j0 z1", "G3 X2 Y0 I1 J0 Z1 F100"),
    ("f100 g2 x2 r1", "G2 X2 Y0 R1 F100"),
    ("f100 g3 x3 y3 r-3", "G3 X3 Y3 R-3 F100"),
    ("f100 g2 i1 p3 z-3", "G2 X0 Y0 Z-3 I1 J0 P3 F100"),
    ("f100 g90.1 g3 x2 y0 i1 j0\ng91.1 g3 x4 i1", "G3 X2 Y0 I1 J0 F100\nG3 X4 Y0 I1 J0"),
    ("g18 g2 x2 z0 i1 f100", "G18 G2 X2 Z0 I1 K0 F100"),
    ("g19 g3 y2 z0 j1 f100\ng17 g0 x1", "G19 G3 Y2 Z0 J1 K0 F100\nG0 X1"),
    ("g4 p0.5", "G4 P0.5"),
    ("g10 l2 p2 x5 y[2*3]", "G10 L2 P2 X5 Y6"),
    ("g10 l20 p1 x5\ng91 g0 x1", "G10 L20 P1 X5\nG0 X6"),
    ("g10 l1 p7 z30 r2.5\ng43 h7", "G43.1 Z30"),
    ("g28.1\ng30.1", "G28.1\nG30.1"),
    ("g28\ng0 x1 y2 z3", "G28\nG0 X1 Y2 Z3"),
    ("g0 z5\ng30 z9", "G0 Z5\nZ9\nG91 G30 Z0\nG90"),
    ("g38.2 z-5 f50\ng0 z1", "G38.2 Z-5 F50\nG0 Z1"),
    ("g38.3 x5 f50\ng38.4 y2\ng38.5 x-1", "G38.3 X5 F50\nG38.4 Y2 F50\nG38.5 X-1 F50"),
    ("t1 m6\ng43\ng0 z5", "M6 T1\nG43.1 Z40\nG0 Z5"),
    ("g43 h2\ng0 z5", "G43.1 Z55.5\nG0 Z5"),
    ("g43 h9\ng0 z5", "G43 H9\nG0 Z5"),
    ("g43.1 z12\ng49", "G43.1 Z12\nG49"),
    ("g43 h1\ng43.2 h2", "G43.1 Z40\nG43.1 Z95.5"),
    ("g53 g0 z0\ng0 x1 z2", "G53 G0 Z0\nG0 X1 Z2"),
    ("g53 g1 x2 f90", "G53 G1 X2 F90"),
    ("f100 g1 x1\nf50 g53 g1 x2\nf100 g1 x3", "G1 X1 F100\nG53 G1 X2 F50\nG1 X3 F100"),
    ("f100 g1 x1\nf50 g38.2 x2\nf100 g1 x3", "G1 X1 F100\nG38.2 X2 F50\nG1 X3 F100"),
    ("g55\ng0 x1 y1", "G55\nG0 X1 Y1"),
    ("g54 g0 x1\ng56\ng57\ng58\ng59", "G54\nG0 X1\nG56\nG57\nG58\nG59"),
    ("g61 g0 x1\ng61.1\ng64 p0.05 q0.01 x2\ng64", "G0 X1\nX2"),
    ("g8 g97 s500 m3", "S500 M3"),
    ("g0 z3\nf60 g98 g81 x4 y5 z1.5 r2.8", "G0 Z3\nX4 Y5\nZ2.8\nG1 Z1.5 F60\nG0 Z3"),
    ("g0 z3\nf60 g99 g81 x4 y5 z1.5 r2.8\nx6", "G0 Z3\nX4 Y5\nZ2.8\nG1 Z1.5 F60\nG0 Z2.8\nX6\nG1 Z1.5\nG0 Z2.8"),
    (
        "g0 x1 y2 z3\nf60 g91 g98 g81 x4 y5 z-0.6 r1.8 l3",
        "G0 X1 Y2 Z3\nZ4.8\n" + "".join(f"G0 X{x} Y{y}\nG1 Z4.2 F60\nG0 Z4.8\n" for x, y in ((5, 7), (9, 12), (13, 17))),
    ),
    ("g0 z3\nf60 g82 x4 z1.5 r2.8 p2", "G0 Z3\nX4 Y0\nZ2.8\nG1 Z1.5 F60\nG4 P2\nG0 Z3"),
    (
        "g0 z3\nf60 g83 x4 z-1 r2 q1.5",
        "G0 Z3\nX4\nZ2\nG1 Z0.5 F60\nG0 Z2\nZ0.754\nG1 Z-1\nG0 Z3",
    ),
    ("g0 z3\nf60 g73 x4 z-1 r2 q1.5", "G0 Z3\nX4\nZ2\nG1 Z0.5 F60\nG0 Z0.754\nG1 Z-1\nG0 Z3"),
    ("s100 m3 f125\ng0 z3\ng84 x4 z-1 r2", "S100 M3\nG0 Z3\nX4\nZ2\nG1 Z-1 F125\nM5\nM4\nG1 Z3\nM5\nM3"),
    ("s100 m3 f125\ng0 z3\ng99 g84 x4 z-1 r2", "S100 M3\nG0 Z3\nX4\nZ2\nG1 Z-1 F125\nM5\nM4\nG1 Z2\nM5\nM3"),
    ("f2000000 g1 x1", "G1 X1 F1000000"),
    ("o1 sub\ng0 x1\no7 return [5]\ng0 x2\no1 endsub\no1 call\ng0 y#<_value>", "G0 X1\nY5"),
    ("f100 g2 x50 i24.986", "G2 X50 Y0 I25 J0 F100"),
    ("f100 g2 x4000 i1999", "G2 X4000 Y0 I2000 J0 F100"),
    ("g20 f1 g2 x5 i2.4986", "G2 X127 Y0 I63.5 J0 F25.4"),
    ("s100 m4 f125\ng0 z3\ng74 x4 z-1 r2 p1", "S100 M4\nG0 Z3\nX4\nZ2\nG1 Z-1 F125\nM5\nM3\nG4 P1\nG1 Z3\nM5\nM4"),
    ("g0 z3\nf60 g85 x4 z-1 r2", "G0 Z3\nX4\nZ2\nG1 Z-1 F60\nZ2\nG0 Z3"),
    ("s100 m3 f60\ng0 z3\ng86 x4 z-1 r2 p1", "S100 M3\nG0 Z3\nX4\nZ2\nG1 Z-1 F60\nG4 P1\nM5\nG0 Z3\nM3"),
    ("s100 m3 f60\ng0 z3\ng88 x4 z-1 r2", "S100 M3\nG0 Z3\nX4\nZ2\nG1 Z-1 F60\nM5\nM0\nG0 Z3\nM3"),
    ("g0 z3\nf60 g89 x4 z-1 r2 p1\ng80", "G0 Z3\nX4\nZ2\nG1 Z-1 F60\nG4 P1\nZ3"),
    ("g0 z-1\nf60 g81 x1 z-2 r1", "G0 Z-1\nZ1\nX1\nG1 Z-2 F60\nG0 Z1"),
    ("g0 x5\ng92 x0\ng91 g0 x1", "G0 X5\nG92 X0\nG0 X1"),
    ("g92.1\ng90 g0 x1", "G92.1\nG0 X1"),
    ("g93 g1 x10 f2\nx20 f4\ng94 x0 f100", "G1 X10 F20\nX20 F40\nX0 F100"),
    ("g93 g3 x0 i5 f2", f"G3 X0 Y0 I5 J0 F{20 * math.pi:.3f}"),
    ("s1000 m3\ng95 g1 x10 f0.1", "S1000 M3\nG1 X10 F100"),
    ("m0\nm1\nm60", "M0\nM1\nM0"),
    ("m3 s100\nm4\nm5\nm7\nm8\nm9\nm48\nm49\nm50 m51 m52 m53", "S100 M3\nM4\nM5\nM7\nM8\nM9"),
    ("m61 q1\ng43", "G43.1 Z40"),
    ("m66 p1\nm66 p0 l3 q[1/4]\nm66 p9 q5", "M66 P1 L0\nM66 P0 L3 Q0.25\nM66 P9 L0"),
    ("m10\nm11\ng0 x1", "M10\nM11\nG0 X1"),
    ("m62 p1\nm63 p1\nm64 p2\nm65 p2", "M62 P1\nM63 P1\nM64 P2\nM65 P2"),
    ("g0 x1\nm2\nx5", "G0 X1\nM2"),
    ("%\ng0 x1\nm30\n%\nx7", "G0 X1\nM30"),
    ("#3=15\n#3=6 g0 x#3\ng0 y#3", "G0 X15\nY6"),
    ("#1=2\n#2=7\ng0 x##1 y#[#1-1] z-#1", "G0 X7 Y2 Z-2"),
    ("#<my place>=4\n#<_all>=5\ng0 x#<myplace> y#<_ALL>", "G0 X4 Y5"),
    ("#<a>=[exists[#<b>]]\ng0 x[exists[#<a>]+1] y[#<a>]", "G0 X2 Y0"),
    ("g0 x3 y4\ng0 x#5421 y#5420 z[#<_x>+#<_y>]", "G0 X3 Y4\nX4 Y3 Z7"),
    ("g20\nt1 m6\ng0 x[#5410] y#5400 z[#<_imperial>+#<_metric>]", "M6 T1\nG0 X6 Y25.4 Z25.4"),
    ("g0 x[2+3*4] y[2**3**2] z[-2**2]", "G0 X14 Y64 Z4"),
    ("g0 x[[2+3]*4] y[7 mod 4] z[-7 mod 4]", "G0 X20 Y3 Z1"),
    ("g0 x[1 eq 1.0000001] y[2 ne 3] z[2 gt 3]", "G0 X1 Y1 Z0"),
    ("g0 x[3 ge 3] y[2 lt 2] z[2 le 2]", "G0 X1 Y0 Z1"),
    ("g0 x[1 and 0] y[1 or 0] z[1 xor 1]", "G0 X0 Y1 Z0"),
    ("g0 x[10 - 3 - 2] y[12/3/2] z[1+2 lt 4 and 5 gt 4]", "G0 X5 Y2 Z1"),
    ("g0 xabs[-2] ysqrt[16] zround[2.5]", "G0 X2 Y4 Z3"),
    ("g0 xfix[-2.5] yfup[2.1] zround[-2.5]", "G0 X-3 Y3 Z-3"),
    ("g0 xsin[30] ycos[60] ztan[45]", "G0 X0.5 Y0.5 Z1"),
    ("g0 xasin[0.5] yacos[0.5] zatan[1]/[-1]", "G0 X30 Y60 Z135"),
    ("g0 xexp[1] yln[exp[2]]", "G0 X2.718282 Y2"),
    ("g0 @10 ^30", "G0 X8.660254 Y5"),
    ("g0 x3 y4\ng91 g0 @5\ng90 ^0", "G0 X3 Y4\nX6 Y8\nX10 Y0"),
    ("o1 sub\ng0 x#1 y#2\no1 endsub\no1 call [3] [4]\ng0 z1", "G0 X3 Y4\nZ1"),
    ("o1 sub\n#1=9\n#<a>=1\no1 endsub [5*2]\n#1=4\no1 call [3]\ng0 x#1 y#<_value> z#<_value_returned>", "G0 X4 Y10 Z1"),
    ("o1 sub\no2 if [#1 gt 0]\ng0 x[#1]\no1 call [#1-1]\no1 return [7]\no2 endif\no1 endsub\no1 call [3]", "G0 X3\nX2\nX1"),
    ("o101 sub\ng0 x5\no101 endsub\n#1=100\no[#1+1] call", "G0 X5"),
    ("#1=0\no1 while [#1 lt 3]\n#1=[#1+1]\ng0 x#1\no1 endwhile", "G0 X1\nX2\nX3"),
    ("#1=5\no1 do\ng0 x#1\n#1=[#1-1]\no1 while [#1 gt 3]", "G0 X5\nX4"),
    ("o1 repeat [3]\ng91 g0 x2\no1 endrepeat", "G0 X2\nX4\nX6"),
    ("#1=0\no1 while [1]\n#1=[#1+1]\no2 if [#1 eq 2]\no1 continue\no2 elseif [#1 gt 3]\no1 break\no2 else\ng0 x#1\no2 endif\n"
     "o1 endwhile\ng0 y1", "G0 X1\nX3\nY1"),
    ("O0007 (a CAM program's number)\ng0 x1", "G0 X1"),
    ("(msg, hello)\n(debug, #1)\ng0 x1", "G0 X1"),
    ("g0 x-10 y5\ng41 d1 g1 x0 f100\ny20\ng40 g0 x-10", "G0 X-10 Y5\nG1 X-3 F100\nY20\nG0 X-10"),
    ("g0 x10 y5\ng42 d1 g1 x0 f100\ny20\ng40 g0 x10", "G0 X10 Y5\nG1 X3 F100\nY20\nG0 X10"),
    ("g0 x-10\ng41.1 d8 g1 x0 f100\ny20\ng40", "G0 X-10\nG1 X-4 Y0 F100\nY20"),
    ("g0 x10\ng42.1 d8 g1 x0 f100\ny20\ng40\nm30", "G0 X10\nG1 X4 Y0 F100\nY20\nM30"),
    ("g91\nm70\ng90 g20 f1 g1 x1\nm72\ng1 x1 f100", "G1 X25.4 F25.4\nX26.4 F100"),
    ("g99 g18 f100\nm70\ng98 g17 f5\nm72 g2 x2 z0 i1", "G18 G2 X2 Z0 I1 K0 F100"),
    ("m3 s500 m8 m70\nm4 s100 m9\nm7 m72\ng0 x1", "S500 M3\nM8\nS100 M4\nM9\nM7\nS500 M3\nM9\nM8\nG0 X1"),
    ("s500 m70\nm5\nm3 s10\nm72\ng0 x1", "S500\nM5\nS10 M3\nS500 M5\nG0 X1"),
    ("g55\nm70\ng54\nm72\ng0 x1", "G55\nG54\nG55\nG0 X1"),
    ("g43 h1\nm70\ng43 h9\nm72\ng0 z5", "G43.1 Z40\nG43 H9\nG43.1 Z40\nG0 Z5"),
    ("g43 h9\nm70\ng49\nm72\ng0 z5", "G43 H9\nG49\nG43 H9\nG0 Z5"),
    ("f90\nm70\ng93 g1 x1 f2\nm72\ng1 x3", "G1 X1 F2\nX3 F90"),
    ("o1 sub\nm73\ng91\ng0 x1\no1 endsub\ng90 g0 x1\no1 call\ng0 x5", "G0 X1\nX2\nX5"),
    ("o1 sub\nm73\ng91\ng0 x1\nm71\no1 return\no1 endsub\ng90 g0 x1\no1 call\ng0 x5", "G0 X1\nX2\nX7"),
    ("o1 sub\nm73\ng91\ng0 x1\no2 call\ng0 x1\no1 endsub\no2 sub\nm73\ng90\no2 endsub\ng0 x1\no1 call\ng0 x5", "G0 X1\nX2\nX3\nX5"),
    ("m98 p1 l2\ng0 x5\nm30\no1\nm73\ng91 g0 x1\nm99", "G0 X1\nX2\nX5\nM30"),
    ("m70\ng41.1 d0\ng1 x5 f100\nx9\nm72\nm70\nm72\ng0 z1", "G1 X5 F100\nX9\nG0 Z1"),
    ("m98 p12 l3\nm98 p12 l0\ng0 y1\nm30\no0012\ng91 g0 x1\nm99", "G0 X1\nX2\nX3\nY1\nM30"),
    ("#1=5\nm98 p1\ng0 x#1\nm30\no1\nm98 p2 l2\nm99\no2\n#1=[#1+1]\nm99", "G0 X7\nM30"),
    ("g0 x1\nm99\ng0 x2", "G0 X1"),
    ("o<part>\ng0 x1\nm2", "G0 X1\nM2"),
    ("g18 f60\ng0 y3\ng81 x4 z5 y1.5 r2.8", "G0 Y3\nX4 Z5\nY2.8\nG1 Y1.5 F60\nG0 Y3"),
    ("g19 f60\ng0 x3\ng99 g82 y4 z5 x1 r2 p1", "G0 X3\nY4 Z5\nX2\nG1 X1 F60\nG4 P1\nG0 X2"),
    ("f60 g0 x2.5\ng99 g81 r1 z-1\n^90\n@1", "G0 X2.5\nG0 Z1\nG1 Z-1 F60\nG0 Z1\nX0 Y2.5\nG1 Z-1\nG0 Z1\nX0 Y1\nG1 Z-1\nG0 Z1"),
    ("f60 g0 z1\ng91 g99 g81 x1 z-2 r1\nx1 r1 z-2", "G0 Z1\nZ2\nX1\nG1 Z0 F60\nG0 Z2\nX2\nG1 Z0\nG0 Z2"),
    ("g10 l2 p1 r90\ng0 x2 y1\ng91 x1\ng90 g1 y0 f60", "G0 X-1 Y2\nX-1 Y3\nG1 X0 Y3 F60"),
    ("g10 l2 p1 r90\nf60\ng2 x2 i1\ng0 x0 y0 z1", "G2 X0 Y2 I0 J1 F60\nG0 X0 Y0 Z1"),
    ("g10 l2 p1 r90\ng10 l20 p1 x1 y0\ng0 x2\ng10 l2 p1 r0\ng0 y1", "G10 L20 P1 X0 Y1\nG0 X0 Y2\nG0 X0 Y1"),
    ("g10 l2 p2 r90\ng55\ng0 x2 y1\ng54\ng0 x2 y1", "G55\nG0 X-1 Y2\nG54\nG0 X2 Y1"),
    ("g10 l2 p1 r90\ng0 x-10 y0\ng41 d1 g1 x0 f100\ny20\ng40", "G0 X0 Y-10\nG1 X0 Y-3 F100\nX-20"),
    ("g18 g0 x-10\ng42 d1 g1 x0 f100\nz20\ng40\nz30", "G0 X-10\nG1 X-3 F100\nZ20\nZ30"),
    ("g0 x-10\ng41 d1 g1 x0 f100\ny20\ng40\ng55\ng0 x1 y1", "G0 X-10\nG1 X-3 F100\nY20\nG55\nG0 X1 Y1"),
    ("g19 g0 y-10\ng41 d1 g1 y0 f100\nz20\ng40", "G0 Y-10\nG1 Y-3 F100\nZ20"),
)  # fmt: skip


@pytest.mark.parametrize("program, plain", EXAMPLES)
def test_words(program, plain):
    found, wanted = events(compiled(program).codes, ZERO), events(plain.split("\n"), ZERO)
    assert same(found, wanted), (found, wanted)


def test_every_code_has_an_example():
    text = "\n".join([program for program, _ in EXAMPLES] + [SPLINES])
    missing = []
    for letter, known in (("g", codes.G_GROUPS), ("m", codes.M_GROUPS)):
        for code in known:
            spelled = f"{letter}{code // 10}" + (f".{code % 10}" if code % 10 else "")
            if not any(text[at + len(spelled)] not in "0123456789." for at in range(len(text) - len(spelled)) if text.startswith(spelled, at)):
                missing.append(spelled)
    assert missing == []


SPLINES = "f90\ng5 x10 y0 i3 j9 p-4 q5\nx20 y5 p-2 q-6\ng5.1 x30 y0 i4 j3\ng5.2 l4\nx32 y6\nx38 y8 p3\nx44 y-4\nx50 y0 p0.5\ng5.3\ng0 z1"


@pytest.mark.parametrize("unit, decimals", [("g21", 3), ("g21", 6), ("g20", 4), ("g20", 6)])
@pytest.mark.parametrize("down", ["", " z-1.5"])
def test_full_turns_stay_turns(unit, decimals, down):
    """For circles with any start and centre, with an end or without: one turn of a program becomes one arc, not a line and not nothing."""
    dice = random.Random(decimals)
    size = 1 if unit == "g21" else 1 / 25.4

    def number(most):
        return f"{dice.uniform(-most, most) * size:.{decimals}f}"

    for _ in range(60):
        x, y = number(40), number(40)
        end = dice.choice(("", f" x{x} y{y}"))
        centre = dice.choice((f"i{number(20)}", f"j{number(20)}", f"i{number(20)} j{number(20)}"))
        way = dice.choice("23")
        listing = compiled(f"#1=10\n{unit} g90 g17 f#1\ng0 x{x} y{y}\ng1 z-0.1\ng{way}{end}{down} {centre}")
        assert sum(line[:2] == b"G%s" % way.encode() for _, line in listing.lines()) == 1, (x, y, end, centre)


def test_splines():
    """Points against the curves' own formulas (Bernstein's polynomials; de Boor's and Cox's functions), chords within 0.002 mm."""
    lines = [event for event in events(compiled(SPLINES).codes, ZERO) if event[0] == "feed"]
    way = LineString([(0, 0), *[event[2][:2] for event in lines]])
    curves = [((0, 0), (3, 9), (6, 5), (10, 0)), ((10, 0), (14, -5), (18, -1), (20, 5)), ((20, 5), (24, 8), (30, 0))]
    wanted = []
    for controls in curves:
        top = len(controls) - 1
        for share in np.linspace(0, 1, 400):
            weights = [math.comb(top, k) * share**k * (1 - share) ** (top - k) for k in range(top + 1)]
            wanted.append(np.array(weights) @ np.array(controls))
    controls, weights, knots = [(30, 0), (32, 6), (38, 8), (44, -4), (50, 0)], [1, 1, 3, 1, 0.5], [0, 0, 0, 0, 1, 2, 2, 2, 2]

    def basis(number, order, at):
        if order == 1:
            return float(knots[number] <= at < knots[number + 1])
        parts = [(at - knots[number], knots[number + order - 1] - knots[number], basis(number, order - 1, at)),
                 (knots[number + order] - at, knots[number + order] - knots[number + 1], basis(number + 1, order - 1, at))]  # fmt: skip
        return sum(above / below * rest for above, below, rest in parts if below)

    for at in np.linspace(0, 2, 800, endpoint=False):
        shares = np.array([basis(number, 4, at) * weight for number, weight in enumerate(weights)])
        wanted.append(shares @ np.array(controls) / shares.sum())
    curve = LineString([*wanted, (50, 0)])
    assert way.hausdorff_distance(curve) < 0.003 and way.length == pytest.approx(curve.length, abs=0.01)
    assert 60 < len(lines) < 600


# (program, number of the error, line)
ERRORS = (
    ("g0 x", 300, 1), ("x1 q", 300, 1), ("g0 x1 é", 300, 1), ("#1 5", 300, 1), ("g0 xatan[1]", 300, 1), ("g0 x[1#2]", 302, 1),
    ("\ng0 x[1+2", 301, 2), ("(no end", 301, 1), ("g0) x1", 301, 1), ("g0 x#<a", 301, 1),
    ("g0 xfoo[1]", 302, 1), ("g0 x[1 foo 2]", 302, 1), ("o1 foo", 302, 1),
    ("g0 x[1/0]", 303, 1), ("g0 x[1 mod 0]", 303, 1),
    ("g0 xsqrt[-1]", 304, 1), ("g0 xln[0]", 304, 1), ("g0 xasin[2]", 304, 1), ("g0 x[[-1]**0.5]", 304, 1), ("g0 xexp[9999]", 304, 1),
    ("g0 x#<a>", 305, 1), ("g0 x#0", 305, 1), ("#6000=1", 305, 1), ("#5420=1", 305, 1),
    ("g38.2 x1 f1\ng0 x#5061", 306, 2), ("#1=#5221", 306, 1), ("m66 p1\ng0 x#5399", 306, 2), ("m66 e0 l0", 311, 1), ("m66 p0 e0 l0", 311, 1), ("m68 e0 q1", 311, 1), ("g0 x1 e1", 315, 1),
    ("g12", 310, 1), ("g0 b1", 310, 1), ("g1.25", 310, 1),
    ("g33 z1 k1", 311, 1), ("g76 x1", 311, 1), ("g87 x1", 311, 1), ("g59.1", 311, 1), ("m67 e0 q1", 311, 1), ("m67 q1", 311, 1),
    ("g92 x1\ng10 l2 p1 r30", 311, 2), ("g10 l2 p1 r30\ng92 x1", 311, 2), ("g10 l2 p1 r9\ng38.2 x1 f1", 311, 2), ("g10 l11 p1 z1", 311, 1), ("g92.2", 311, 1), ("g53 g2 x1 i1", 311, 1),
    ("g0 g1 x1 f1", 312, 1), ("g17 g18", 312, 1), ("m3 m4", 312, 1),
    ("g0 x1 x2", 313, 1),
    ("g4", 314, 1), ("g10 l20 p1", 314, 1), ("g5 x1 f1", 314, 1), ("g5 i1 j1 p1 q1 f1", 314, 1), ("g5.3", 314, 1), ("m72", 323, 1), ("m70\nm71\nm72", 323, 3), ("m70\no1 call\nm30\no1 sub\nm72\no1 endsub", 323, 5),
    ("m70\ng43 h1\nm72", 311, 3), ("g41 d1\nm70\ng40\nm72", 311, 4), ("m70 m72", 312, 1), ("g5.2 x1 f1\ng1 x2", 314, 2), ("m98", 314, 1),
    ("g10 l2 p2 r30\ng10 l20 p2 x1", 314, 2), ("g81 x1 z-1 f1", 314, 1), ("g83 x1 z-1 r1 f1", 314, 1), ("g92", 314, 1), ("g41.1", 314, 1),
    ("g38.2 f1", 314, 1), ("g2 r5 f1", 314, 1), ("m66 l3 q1", 314, 1),
    ("g0 x1 q5", 315, 1), ("g10 l20 p1 x1 r9", 315, 1), ("g80\nx1", 315, 2), ("p1", 315, 1),
    ("g0 x" + "9" * 400, 304, 1), ("g0 x[9999999**40*9999999**40]", 304, 1), ("g0 x" + "[" * 3000, 301, 1), ("g0 x[10**7]", 316, 1),
    ("g83 z-1 r1 q[10**-7] f1", 334, 1), ("g4 p-1", 316, 1), ("m66 p1 l1", 316, 1), ("m66 p1 l3 q0", 316, 1), ("m66 p1 l5 q1", 316, 1), ("m66 p10", 316, 1), ("g5.2 x1 p-1 f1", 316, 1), ("g5.2 x1 f1\ng5.3", 316, 2), ("g5.1 x1 z1 i1 j1 f1", 316, 1), ("t256", 316, 1), ("g10 l2 p7 x1", 316, 1), ("g81 x1 z2 r1 f1", 316, 1), ("g83 z-1 r1 q0 f1", 316, 1), ("s-5", 316, 1),
    ("t1.5", 317, 1), ("m66 p1 l0.5", 317, 1), ("#1.5=1", 317, 1),
    ("g0 g92 x1", 318, 1), ("g28 g38.2 x1 f1", 318, 1),
    ("g1 x1", 319, 1), ("g93 g1 x1 f2\nx2", 319, 2), ("f100\ng93 g81 x1 z-1 r1 f1", 319, 2), ("f-1", 319, 1), ("f5\ng93\ng94 g1 x1", 319, 3),
    ("g2 x2 i5 f1", 321, 1), ("g2 x20 r1 f1", 321, 1), ("g2 x1 f1", 321, 1), ("g2 x1 k1 f1", 321, 1), ("g2 r5 x0 f1", 321, 1),
    ("g84 z-1 r1 f1", 322, 1), ("g95 g1 x1 f1", 322, 1),
    ("o1 endif", 330, 1), ("o1 if [1]\no2 endif", 330, 2), ("o1 break", 330, 1), ("o1 else", 330, 1), ("o1 sub\no2 sub", 330, 2),
    ("o1 sub\no1 endsub\no1 sub\no1 endsub", 330, 3), ("o[#1] while [1]", 330, 1),
    ("\no1 while [1]\ng0 x1", 331, 2), ("o1 sub\n", 331, 1), ("m98 p1\nm30\no1\ng0 x1", 331, 1), ("m98 p1\no1\no2 sub\nm99\no2 endsub\no2 call", 330, 4),
    ("o1 call", 332, 1), ("m98 p1", 332, 1), ("m98 p1\nm30\no1 sub\no1 endsub", 332, 1), ("o<none> call", 332, 1),
    ("o1 sub\no1 call\no1 endsub\no1 call", 333, 2), ("m98 p1\nm30\no1\nm98 p1\nm99", 333, 4),
    ("o1 while [1]\n#1=2\no1 endwhile", 334, 2),
    ("g41 d9", 340, 1), ("g41", 340, 1), ("g43.2 h1", 340, 1),
    ("g0 x0 y0\ng41 d1\ng2 i5 f1\ng40", 341, 3),
    ("g0 x0 y0\ng41 d1\ng3 x0.5 y0.5 j0.5 f1\ng40", 341, 3),
    ("g0 x-10 y1\ng41 d1 g1 x20 y0 f1\ng1 x0\nx-20\ng40", 342, 2),
    ("g0 x-10\ng41 d1 g1 x0 f1\ny10\ng3 x4 i2\ng1 y0\ng40", 343, 4),
    ("g0 x-10\ng42 d1 g1 x0 f1\ng1 y10\nx3\ny0\ng40", 343, 5),
    ("g0 x-10 y-20\ng41 d1 g1 x0 y-10 f1\ny30\nx10\ny26\nx0.5\ng40", 344, 6),
    ("g0 x-10\ng41 d1 g1 x0 f1\ny10\ng40\ng1 x1 y5", 345, 5),
    ("g18 g5 x1 i1 j1 p1 q1 f1", 346, 1), ("g10 l2 p1 r30\ng18 g41 d1", 346, 2), ("g10 l2 p1 r30\ng18 g2 x2 i1 f1", 346, 2),
    ("g41 d1\ng18 g2 x2 i1 f1", 347, 2), ("g41 d1\ng28", 347, 2), ("g41 d1\ng81 x1 z-1 r1 f1", 347, 2), ("g41 d1\ng92 x0", 347, 2), ("g41 d1\nm6 t1", 347, 2),
)  # fmt: skip


@pytest.mark.parametrize("program, number, line", ERRORS)
def test_errors(program, number, line):
    with pytest.raises(ProgramError) as refusal:
        compiled(program, bound=1000)
    assert (refusal.value.number, refusal.value.place.line) == (number, line), str(refusal.value)
    assert f"p.ngc:{line}: error {number}: {TEXTS[number]}" in str(refusal.value)


def test_a_place_that_nobody_knows():
    nowhere = (None, None, None)
    for program in ("g91 g0 x1", "g0 y0\ng1 x5 f1\ng28\ng2 x0 i1", "g0 x0 y0\ng54\ng55\ng91 g0 x1", "g0 x0 y0\ng81 x1 z-1 r1 f1"):
        with pytest.raises(ProgramError) as refusal:
            compiled(program, start=nowhere)
        assert refusal.value.number == 320 and "--start" in str(refusal.value)
    assert compiled("g91 g0 x1", start=(4.0, 0.0, 0.0)).codes == ["G0 X5"]
    assert compiled("g0 x5", start=nowhere).codes == compiled("g0 x5").codes


def test_endless_listing():
    with pytest.raises(ProgramError, match="p.ngc:2: error 334"):
        compiled("o1 repeat [500]\ng0 x#5\no1 endrepeat".replace("x#5", "x[#5+1]\n#5=[#5+1]"), most=100)


def test_block_delete():
    assert compiled("g0 x1\n/g0 x2", skip=True).codes == ["G0 X1"]


def test_origins():
    """Each line of a listing says where it came from, loops and subroutines too; an error in a subroutine names its own file."""
    listing = Listing()
    files = {"deep": "o<deep> sub\ng0 x[#1]\no<deep> endsub\nm2\n"}
    find = lambda label: (label + ".ngc", files[label]) if label in files else None  # noqa: E731
    texts = compile_program("p.ngc", "g0 y1\no1 repeat [2]\no<deep> call [#5+1]\n#5=[#5+1]\no1 endrepeat\ng0 y0", listing, {}, find=find)
    assert [str(source) for source in listing.sources] == ["p.ngc:1", "deep.ngc:2", "deep.ngc:2", "p.ngc:6"]
    assert listing.text(texts).splitlines()[1] == "G0 X1                            ; deep.ngc:2: g0 x[#1]"
    assert [str(stroke.source) for stroke in listing.strokes] == [str(source) for source in listing.sources]
    files["bad"] = "o<bad> sub\n\ng0 x[1/0]\no<bad> endsub"
    with pytest.raises(Failure, match="bad.ngc:3: error 303"):
        compile_program("p.ngc", "o<bad> call", Listing(), {}, find=find)


# --- random programs, against an evaluator of their own: trees, walked in Python

LEVELS = {"**": 0, "*": 1, "/": 1, "mod": 1, "+": 2, "-": 2, "eq": 3, "ne": 3, "gt": 3, "ge": 3, "lt": 3, "le": 3, "and": 4, "or": 4, "xor": 4}
MEANING = {
    "**": lambda a, b: a**b, "*": lambda a, b: a * b, "/": lambda a, b: a / b, "mod": lambda a, b: a - b * math.floor(a / b),
    "+": lambda a, b: a + b, "-": lambda a, b: a - b, "eq": lambda a, b: 1.0 if abs(a - b) < 1e-6 else 0.0,
    "ne": lambda a, b: 0.0 if abs(a - b) < 1e-6 else 1.0, "gt": lambda a, b: 1.0 if a > b else 0.0,
    "ge": lambda a, b: 1.0 if a - b > -1e-6 else 0.0, "lt": lambda a, b: 1.0 if a < b else 0.0,
    "le": lambda a, b: 1.0 if b - a > -1e-6 else 0.0, "and": lambda a, b: float(a != 0 and b != 0),
    "or": lambda a, b: float(a != 0 or b != 0), "xor": lambda a, b: float((a != 0) != (b != 0)),
}  # fmt: skip
ONE = {
    "abs": abs, "sin": lambda a: math.sin(a * math.pi / 180), "cos": lambda a: math.cos(a * math.pi / 180), "fix": math.floor,
    "fup": lambda a: -math.floor(-a), "round": lambda a: math.copysign(math.floor(abs(a) + 0.5), a),
}  # fmt: skip


class Writer:
    """Writes a random program and, as it goes, nothing else: `run` carries out its tree."""

    def __init__(self, seed):
        self.random = random.Random(seed)
        self.labels = iter(range(100, 10_000))
        self.names = ["#31", "#32", "#<a>", "#<_b>"]
        self.tree = self.block(3)

    def expression(self, depth):
        pick = self.random.random()
        if depth == 0 or pick < 0.25:
            return self.random.choice(self.names) if self.random.random() < 0.5 else round(self.random.uniform(-9, 9), 2)
        if pick < 0.4:
            return (self.random.choice(list(ONE)), self.expression(depth - 1))
        operator = self.random.choice(list(LEVELS))
        right = self.expression(depth - 1)
        if operator in ("/", "mod"):
            right = ("+", ("abs", right), 1.0)
        if operator == "**":
            right = float(self.random.randrange(3))
        return (operator, self.expression(depth - 1), right)

    def block(self, depth):
        return [self.statement(depth) for _ in range(self.random.randrange(1, 5))]

    def statement(self, depth):
        kind = self.random.choice(("set", "go", "go", "if", "while", "repeat", "do") if depth else ("set", "go"))
        if kind == "set":
            return kind, self.random.choice(self.names), self.expression(3)
        if kind == "go":
            return kind, self.expression(3), self.expression(2)
        label = next(self.labels)
        if kind == "if":
            return kind, label, self.expression(2), self.block(depth - 1), self.expression(2), self.block(depth - 1), self.block(depth - 1)
        return kind, label, self.random.randrange(0 if kind != "do" else 1, 4), self.block(depth - 1)

    # --- as text

    def text(self):
        rows = [f"{name}={value}" for value, name in enumerate(self.names)] + ["g0 x0 y0 z0", "f100"]
        self._write(self.tree, rows)
        return "\n".join(rows)

    def spell(self, tree, level=5):
        if isinstance(tree, str):
            return tree
        if isinstance(tree, float):
            return str(tree)
        if len(tree) == 2:
            return f"{tree[0]}[{self.spell(tree[1])}]"
        mine = LEVELS[tree[0]]
        left, right = self.spell(tree[1], mine), self.spell(tree[2], mine - 1)  # equal ones go from left to right
        text = f"{left} {tree[0]} {right}"
        return f"[{text}]" if mine > level else text

    def _write(self, block, rows):
        for statement in block:
            kind = statement[0]
            if kind == "set":
                rows.append(f"{statement[1]}=[{self.spell(('mod', statement[2], 97.0))}]")
            elif kind == "go":
                rows.append(f"g1 x[{self.spell(('mod', statement[1], 90.0))}] y[{self.spell(('mod', statement[2], 70.0))}]")
            elif kind == "if":
                _, label, one, first, two, second, third = statement
                rows.append(f"o{label} if [{self.spell(one)}]")
                self._write(first, rows)
                rows.append(f"o{label} elseif [{self.spell(two)}]")
                self._write(second, rows)
                rows.append(f"o{label} else")
                self._write(third, rows)
                rows.append(f"o{label} endif")
            else:
                _, label, count, body = statement
                counter = f"#<n{label}>"
                rows += [f"{counter}=0"] * (kind != "repeat")
                rows.append(
                    {"while": f"o{label} while [{counter} lt {count}]", "do": f"o{label} do", "repeat": f"o{label} repeat [{count}]"}[kind]
                )
                rows += [f"{counter}=[{counter}+1]"] * (kind != "repeat")
                self._write(body, rows)
                rows.append({"while": f"o{label} endwhile", "do": f"o{label} while [{counter} lt {count}]", "repeat": f"o{label} endrepeat"}[kind])

    # --- as motions

    def run(self):
        self.values = {name: float(value) for value, name in enumerate(self.names)}
        self.places = [(0.0, 0.0)]
        self._run(self.tree)
        return self.places

    def value(self, tree):
        if isinstance(tree, str):
            return self.values[tree]
        if isinstance(tree, float):
            return tree
        if len(tree) == 2:
            return float(ONE[tree[0]](self.value(tree[1])))
        return MEANING[tree[0]](self.value(tree[1]), self.value(tree[2]))

    def _run(self, block):
        for statement in block:
            kind = statement[0]
            if kind == "set":
                self.values[statement[1]] = MEANING["mod"](self.value(statement[2]), 97.0)
            elif kind == "go":
                self.places.append((MEANING["mod"](self.value(statement[1]), 90.0), MEANING["mod"](self.value(statement[2]), 70.0)))
            elif kind == "if":
                self._run(statement[3] if self.value(statement[2]) else statement[5] if self.value(statement[4]) else statement[6])
            else:
                for _ in range(statement[2]):
                    self._run(statement[3])


def test_random_programs():
    """200 programs with nested loops, conditions and expressions; every place they go to."""
    motions = nested = 0
    for seed in range(200):
        writer = Writer(seed)
        text = writer.text()
        expected = [place for place in writer.run()]
        kept = [expected[0]] + [place for before, place in zip(expected, expected[1:]) if math.dist(before, place) > 1.5e-5]
        listing = compiled(text, bound=2_000_000, start=(None, None, None))
        found = [event[-1][:2] for event in events(listing.codes) if event[0] in ("rapid", "feed")]
        steps = [found[0]] + [place for before, place in zip(found, found[1:]) if math.dist(before, place) > 1.5e-5]
        assert same(steps, kept, 3e-5), (seed, text)
        motions += len(kept)
        nested += sum(1 for row in text.splitlines() if row.startswith("o"))
    assert motions > 3000 and nested > 1000


@pytest.mark.parametrize("program, line", [
    ("o1 while [1]\ng1 x1 f100\ng1 x2\no1 endwhile", 4), ("o1 do\ng4 p1\no1 while [#1 lt 5]", 3),
    ("o1 while [1]\n#1=[1-#1]\no1 endwhile", 3), ("o1 sub\no2 while [1]\nm70\nm72\no2 endwhile\no1 endsub\no1 call", 5),
])  # fmt: skip
def test_a_loop_that_changes_nothing_is_found_at_once(program, line):
    with pytest.raises(ProgramError) as found:
        compiled(program, bound=1_000_000, most=5000)
    assert (found.value.number, found.value.place.line) == (334, line)


@pytest.mark.parametrize("loop, after", [
    ("#1=[#1+1]\no1 while [#1 lt 3000]", 3000), ("#1=[1-#1]\n#2=[#2+1]\no1 while [#2 lt 2999]", 1),
    ("#<a>=[#<_value_returned>]\n#<b>=[#<b>+1]\n#1=#<b>\no1 while [#<b> lt 2500]", 2500), ("g91 g0 x1\n#1=#5420\no1 while [#5420 lt 2500]", 2500),
])  # fmt: skip
def test_a_long_loop_that_ends_is_carried_out(loop, after):
    listing = compiled(f"#<b>=0\no1 do\n{loop}\ng90 g0 y#1")
    assert listing.codes[-1].split()[-1] == f"Y{after}"
