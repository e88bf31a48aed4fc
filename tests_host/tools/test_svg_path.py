"""Path data beside svgelements' reader, which is another one; up to the first mistake; and soon."""

import time

import numpy
import pytest
import svgelements
from hypothesis import given, settings
from hypothesis import strategies as st

from host_tools.drawings import svg_geometry, svg_path

NUMBER = st.one_of(st.integers(-99, 99).map(str), st.floats(-99, 99).map("{:.3f}".format), st.sampled_from(["1e1", "-.5", "+2", "3E-1"]))
RADIUS, FLAG = st.integers(1, 60).map(str), st.sampled_from("01")
SETS = {"M": (NUMBER,) * 2, "L": (NUMBER,) * 2, "H": (NUMBER,), "V": (NUMBER,), "C": (NUMBER,) * 6, "S": (NUMBER,) * 4, "Q": (NUMBER,) * 4, "T": (NUMBER,) * 2,
        "A": (RADIUS, RADIUS, NUMBER, FLAG, FLAG, NUMBER, NUMBER), "Z": ()}  # fmt: skip
APART = st.sampled_from([" ", ",", " , ", "\n", "\t "])


@st.composite
def paths(draw):
    data = draw(st.sampled_from(["M", "m"])) + " ".join(draw(st.tuples(NUMBER, NUMBER)))
    for _each in range(draw(st.integers(0, 9))):
        letter = draw(st.sampled_from([*SETS, *"mlhvcsqtaz"]))
        data += letter
        for number in range(draw(st.integers(1, 3)) if letter not in "Zz" else 0):
            between = draw(APART)
            data += (between if number else "") + between.join(draw(st.tuples(*SETS[letter.upper()])))
    return data


class Path(svgelements.Path):
    """S goes on from C and S only, T from Q and T only; behind others the control point is the current point."""

    _kind = svgelements.CubicBezier

    def smooth_cubic(self, *points, **options):
        self._kind = svgelements.CubicBezier
        return super().smooth_cubic(*points, **options)

    def smooth_quad(self, *points, **options):
        self._kind = svgelements.QuadraticBezier
        return super().smooth_quad(*points, **options)

    @property
    def smooth_point(self):
        return super().smooth_point if isinstance(self[-1], self._kind) else self.current_point


@settings(deadline=None)
@given(paths())
def test_places_are_those_of_svgelements(data):
    segments, whole = svg_path.read(data)
    assert whole
    path = Path()
    path.parse(data)
    ends = [point for kind, *points in segments for point in (points[0] if kind == "L" else points[-1:])]
    assert ends == pytest.approx([complex(each.end) for each in path])
    ours = [points[:-1] for kind, *points in segments if kind in "CQ"]
    theirs = [[each.control1, each.control2] if isinstance(each, svgelements.CubicBezier) else [each.control] for each in path
              if isinstance(each, (svgelements.CubicBezier, svgelements.QuadraticBezier))]  # fmt: skip
    assert [point for each in ours for point in each] == pytest.approx([complex(point) for each in theirs for point in each])


@pytest.mark.parametrize("data, ends, whole", [
    ("M1 1L5 5 6", [1 + 1j, 5 + 5j], False), ("M1 1L5 5 x 7 7", [1 + 1j, 5 + 5j], False), ("M1 1L", [1 + 1j], False), ("L5 5", [], False), ("", [], True), (" \n", [], True),
    ("M1,1,5-5.5.5", [1 + 1j, 5 - 5.5j], False), ("M1 1-5-5.5.5 2", [1 + 1j, -5 - 5.5j, 0.5 + 2j], True), ("M1 1z5", [1 + 1j, 1 + 1j], False), ("M0 0A9 9 0 0110 0", [0, 10], True),
    ("M0 0a9 9 0 2 1 10 0", [0], False), ("M0 0h1e1v2h-1e+1", [0, 10, 10 + 2j, 2j], True), ("M0 0 1 1e", [0, 1 + 1j], False), ("M", [], False), ("m3 4zl1 1", [3 + 4j, 3 + 4j, 4 + 5j], True), ("M1 1 C 2 2 3 3", [1 + 1j], False),
])  # fmt: skip
def test_it_is_read_up_to_its_first_mistake(data, ends, whole):
    segments, right = svg_path.read(data)
    assert [point for kind, *points in segments for point in (points[0] if kind == "L" else points[-1:])] == ends and right == whole


@given(st.text("MLzhCqSTa019.-e, x", max_size=60))
def test_any_text_is_read(data):
    segments, _whole = svg_path.read(data)
    lines = svg_geometry.flatten_segments(segments, 0.1)
    assert all(len(line) > 1 and numpy.isfinite(line).all() for line in lines)


@pytest.mark.parametrize("data", ["M" + "1" * 200_000 + "x", "M1 1" + "l1 2" * 100_000, "M1 1L" + " ," * 200_000 + "x", "M0 0A" + "1" * 100_000 + "z"])
def test_long_data_take_no_time(data):
    begun = time.process_time()
    svg_path.read(data)
    assert time.process_time() - begun < 3
