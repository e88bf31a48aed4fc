"""Joining polylines: nothing gets lost, and nothing that meets is left; lines that no other meets are not looked at one by one."""

import math

import numpy
import pytest
from hypothesis import given
from hypothesis import strategies as st

from host_tools.drawings import line_order
from host_tools.drawings.line_order import join, travel_length

TOLERANCE = 0.05
coordinates = st.one_of(st.integers(-20, 20).map(lambda value: value / 4), st.floats(-300, 300))
points = st.builds(complex, coordinates, coordinates)
polylines = st.lists(points, min_size=2, max_size=4).map(lambda line: numpy.array(line, dtype=complex))
many = st.lists(polylines, max_size=40)


def length(lines):
    return sum(float(abs(numpy.diff(line)).sum()) for line in lines)


@given(many)
def test_joining_loses_and_adds_nothing(lines):
    found = join(lines, TOLERANCE)
    assert sum(map(len, found)) == sum(map(len, lines))
    gaps = len(lines) - len(found)
    assert gaps >= 0 and abs(length(found) - length(lines)) <= gaps * TOLERANCE + 1e-6
    every = sorted((place.real, place.imag) for line in lines for place in line)
    assert sorted((place.real, place.imag) for line in found for place in line) == every


@given(many)
def test_no_two_ends_that_meet_are_left(lines):
    found = join(lines, TOLERANCE)
    for index, line in enumerate(found):
        for other in found[index + 1 :]:
            apart = min(abs(a - b) for a in (line[0], line[-1]) for b in (other[0], other[-1]))
            assert apart > TOLERANCE or _closed(line) or _closed(other)


def _closed(line):
    """Whether the line's ends meet: a closed line has its own end as its nearest."""
    return abs(line[0] - line[-1]) <= TOLERANCE


@given(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 5)), min_size=1, max_size=40))
def test_as_few_lines_as_there_can_be(pairs):
    """Between six places: half of those where an odd number of ends meets, one where that is none, in each that hangs
    together."""
    corners = [0j, 10 + 0j, 20 + 3j, 5 + 9j, 15 + 9j, 9 + 4j]
    lines = [numpy.array([corners[a], 0.3 * number + 30j, corners[b]]) for number, (a, b) in enumerate(pairs)]
    group = {node: {node} for pair in pairs for node in pair}
    for a, b in pairs:
        both = group[a] | group[b]
        group.update(dict.fromkeys(both, both))
    degrees = {node: sum(pair.count(node) for pair in pairs) for node in group}
    wanted = sum(max(1, sum(degrees[node] % 2 for node in nodes) // 2) for nodes in {frozenset(g) for g in group.values()})
    found = join(lines, TOLERANCE)
    assert len(found) == wanted and abs(length(found) - length(lines)) < 1e-6


def test_a_chain_in_any_order_and_direction_is_one_line():
    corners = [complex(i, i % 2) for i in range(30)]
    parts = [numpy.array([a, b] if i % 3 else [b, a]) for i, (a, b) in enumerate(zip(corners, corners[1:]))]
    parts = parts[::2] + parts[1::2]
    (line,) = join(parts, TOLERANCE)
    assert math.isclose(length([line]), length(parts))


@pytest.mark.parametrize("lines", [[], [numpy.array([1j])]])
def test_nothing(lines):
    assert join(lines, TOLERANCE) == []


def test_lines_that_meet_no_other_stay_as_they_are(monkeypatch):
    """A hundred thousand of them take no time; the others are joined among them."""
    chance = numpy.random.default_rng(4)
    places = chance.uniform(0, 1000, 5000) + 1j * chance.uniform(0, 1000, 5000)
    lines = [numpy.array([place, place + 0.3 + 0.2j]) for place in places]
    lines[77:79] = [numpy.array([-5 + 0j, -4 + 1j]), numpy.array([-3 + 0j, -4.01 + 1j])]
    lines += [numpy.array([2000j, 2000j + numpy.exp(1j * math.tau * turn / 40)]) for turn in range(40)]  # more of them at one place than are compared
    looked_at = []
    trails = line_order._find_trails
    monkeypatch.setattr(line_order, "_find_trails", lambda some, radius: looked_at.append(len(some)) or trails(some, radius))
    found = join(lines, TOLERANCE)
    assert looked_at[0] < 60
    assert len(found) == 5000 - 1 + 20 and sum(map(len, found)) == sum(map(len, lines))
    assert travel_length([numpy.array([0j, 3j]), numpy.array([3 + 3j, 0j])], 4 + 0j) == 4 + 3
