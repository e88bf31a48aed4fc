"""Lead-ins and lead-outs of radius compensation: by shapely no contour is gouged; LinuxCNC's interpreter says what should be accepted."""

import collections
import math
import random

import numpy as np
import pytest

import rs274
from host_tools.programs.listing import Listing
from host_tools.programs.ngc.interpreter import compile_program
from host_tools.programs.num.interpreter import compile_program as compile_num
from host_tools.programs.program_errors import DOES_NOT_FIT, ProgramError
from host_tools.programs.tool_table import Tool
from leads import KINDS, Case
from plain_reader import cut_points, events

_DEEPEST_MM = 0.006  # TOUCH, plus the error of chords and five decimals
_NOWHERE = (None, None, None)


def path_of(compiler, text, radius):
    """Points of the cuts. Raises ProgramError."""
    listing = Listing()
    compiler("p.ngc", text, listing, {1: Tool(2 * radius)}, _NOWHERE)
    assert listing.warnings == []
    (points,) = cut_points(events(listing.codes))
    return points


def tried(seed, count):
    """[(case, points or None, ProgramError or None)]"""
    draw = random.Random(seed)
    for number in range(count):
        case = Case(draw, KINDS[number % len(KINDS)])
        try:
            yield case, path_of(compile_program, case.text, case.radius), None
        except ProgramError as error:
            yield case, None, error


@pytest.mark.parametrize("seed, count", [(11, 60), pytest.param(12, 500, marks=pytest.mark.slow)])
def test_no_gouge_in_500_contours(seed, count):
    """Those refused have corners or arcs that are too small for the tool, or no room for the lead-in; the others are followed all the
    way, and nothing else is cut."""
    found = collections.Counter()
    for case, points, error in tried(seed, count):
        found[case.kind, case.inside, error is None] += 1
        if error is None:
            assert case.gouge(points) < _DEEPEST_MM, case.text
            assert case.missed(points) < 0.1, case.text
        else:
            assert error.number == DOES_NOT_FIT or case.crowded() or case.kind == "edge", (str(error), case.text)
    for kind in KINDS:
        for inside in (False, True):
            assert found[kind, inside, True] > count / 100, found


def test_num_goes_the_same_way():
    same = 0
    for case, points, error in tried(12, 60):
        if error is None:
            assert np.allclose(path_of(compile_num, case.num, case.radius), points, atol=5e-5)
            same += 1
        else:
            with pytest.raises(ProgramError) as refusal:
                path_of(compile_num, case.num, case.radius)
            assert refusal.value.number == error.number
    assert same > 30


@pytest.mark.slow
@pytest.mark.skipif(not rs274.RS274, reason="needs rs274: apt-get install linuxcnc-uspace")
def test_what_linuxcnc_accepts_without_a_gouge(tmp_path):
    """Of 500 contours each that LinuxCNC follows without a gouge is accepted."""
    program, table = tmp_path / "p.ngc", tmp_path / "p.tbl"
    compared = 0
    for case, points, error in tried(13, 500):
        program.write_text(case.text)
        table.write_text(f"T1 P1 D{2 * case.radius / 25.4:.8f}\n")
        other = rs274.of_linuxcnc(program, table)
        if other is None or case.gouge(np.vstack([rows for rapid, rows, _ in other if not rapid])[:, :2]) > _DEEPEST_MM:
            continue
        compared += 1
        assert error is None, (str(error), case.text)
    assert compared > 250


def test_a_lead_in_through_the_part_is_refused():
    """From the part's middle along an edge, and a way in across the part: the tool would cut into what the contour leaves."""
    square = "x20\ny20\nx0\ny0"
    for text, number in (
        (f"g0 x10 y10\ng42 d1 g1 x10 y5 f100\nx0 y5\ny0\n{square}\nx-5\ng40 x-9", 344),
        (f"g0 x10 y30\ng42 d1 g1 x-5 y0 f100\n{square}\ny-5\ng40 y-9", 342),
        (f"g0 x-9 y-9\ng42 d1 g1 x-5 y0 f100\n{square}\ny-5\ng40 x10 y30", 345),
    ):
        with pytest.raises(ProgramError) as refusal:
            path_of(compile_program, text, 1.0)
        assert refusal.value.number == number, text


@pytest.mark.parametrize("out, told", [("g1 x-8 y0", False), ("g2 x-8 y8 i0 j8", False), ("g3 x-8 y8 i0 j8", True)])
def test_a_lead_out_through_the_part_is_told(out, told):
    """From a corner of the plate, whose edges leave it, and an arc that takes a bite of it: it may be wanted, so it is a warning."""
    listing = Listing()
    text = f"g0 x-20 y-10\ng41 d1 g1 x-8 y0 f100\nx0\ny40\nx40\ny0\nx0\n{out}\ng40 g1 x-20 y-10"
    compile_program("p.ngc", text, listing, {1: Tool(4.0)}, _NOWHERE)
    assert bool(listing.warnings) == told and all(warning.startswith("p.ngc:8:") for warning in listing.warnings)


def test_an_arc_as_first_motion():
    """It ends beside its own end, along it; an inside corner behind it cuts it off, an outside corner is gone around."""
    points = path_of(compile_program, "g0 x-5 y5\ng41 d1 g3 x0 y0 i5 j0 f100\ng1 x20\ng40 y9", 2.0)
    assert math.dist(points[0], (-5, 5)) < 1e-6 and min(math.dist(point, (0, 2)) for point in points) < 2e-5
    for corner, touches in (("x10 y10", False), ("x10 y-10", True)):
        points = path_of(compile_program, f"g0 x-5 y5\ng41 d1 g3 x0 y0 i5 j0 f100\ng1 {corner}\ng40 x20 y5", 2.0)
        assert (min(math.dist(point, (0, 2)) for point in points) < 2e-5) == touches
    with pytest.raises(ProgramError) as refusal:
        path_of(compile_program, "g0 x-5 y5\ng41 d1 g3 x0 y0 i5 j0 f100\ng1 x20\ng40 y9", 6.0)
    assert refusal.value.number == 341
