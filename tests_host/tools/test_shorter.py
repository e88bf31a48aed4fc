"""Shorter ways: the same ink, never longer than greedy, closed lines entered anywhere, the same order every time."""

import random
import time

import numpy
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from host_tools.drawings import shorter
from host_tools.drawings.line_order import sorted_from, travel
from host_tools.drawings.shorter import shortened

POINTS = st.builds(complex, st.integers(0, 100), st.integers(0, 100))
OPEN = st.lists(POINTS, min_size=2, max_size=5).map(numpy.array)
CLOSED = st.lists(POINTS, min_size=3, max_size=6).map(lambda places: numpy.array([*places, places[0]]))
MANY = st.lists(st.one_of(OPEN, CLOSED), max_size=40)


def ink(lines):
    return sorted(tuple(sorted(((a.real, a.imag), (b.real, b.imag)))) for line in lines for a, b in zip(line, line[1:]))


@settings(deadline=None)
@given(MANY, POINTS)
def test_the_same_ink_on_no_longer_a_way(lines, place):
    made = shortened(lines, place)
    assert len(made) == len(lines) and ink(made) == ink(lines)
    assert travel(made, place) <= travel(lines, place) + 1e-6
    for line in made:
        assert any(len(line) == len(each) and ink([line]) == ink([each]) for each in lines)
    again = shortened(lines, place)
    assert all((a == b).all() for a, b in zip(made, again))


def test_a_closed_line_is_entered_where_it_suits():
    square = numpy.array([0, 10, 10 + 10j, 10j, 0])
    (line,) = shortened([square], 11 + 11j)
    assert line[0] == line[-1] == 10 + 10j and ink([line]) == ink([square])
    made = shortened([square, numpy.array([12 + 10j, 20 + 10j])], -1 + 10j)
    assert travel(made, -1 + 10j) <= 1 + abs(12 + 10j - 10j) + 1e-9


@pytest.mark.parametrize("closed, share", [(False, 0.77), (True, 0.72)])
def test_a_field_of_lines_takes_a_quarter_less_than_greedy(closed, share):
    """Greedy is what vpype's linesort does; its two-opt takes a sixth off a field of lines."""
    chance = random.Random(3)

    def one():
        x, y = complex(chance.uniform(0, 1000), chance.uniform(0, 1000)), complex(chance.uniform(-15, 15), chance.uniform(-15, 15))
        return x + y * numpy.exp(2j * numpy.pi * numpy.arange(13) / 12) if closed else numpy.array([x, x + y])

    greedy = sorted_from([one() for _ in range(800)], 0j)
    if closed:
        greedy = [numpy.append(line[:-1], line[0]) for line in greedy]
    assert travel(shortened(greedy, 0j), 0j) < share * travel(greedy, 0j)


def field(count, side):
    chance = random.Random(3)
    places = [complex(chance.uniform(0, side), chance.uniform(0, side)) for _ in range(count)]
    return [numpy.array([place, place + complex(chance.uniform(-3, 3), chance.uniform(-3, 3))]) for place in places]


def test_a_move_takes_no_more_lines_along_than_told(monkeypatch):
    """Else the time is that of the square of the lines."""
    monkeypatch.setattr(shorter, "_FARTHEST", 50)
    moved, arrange = [], shorter._Tour._arrange

    def watched(self, low, pieces):
        moved.append(sum(last - first + 1 for first, last, _ in pieces))
        arrange(self, low, pieces)

    monkeypatch.setattr(shorter._Tour, "_arrange", watched)
    greedy = sorted_from(field(1500, 100), 0j)
    shares = []
    made = shortened(greedy, 0j, shares.append)
    assert ink(made) == ink(greedy) and travel(made, 0j) < 0.95 * travel(greedy, 0j)
    assert len(moved) > 100 and max(moved) <= 50 + shorter._LONGEST
    assert shares[0] == 0 and shares[-1] <= 1


def test_many_lines_are_kicked_less_and_move_less_far(monkeypatch):
    """A kick of 20 000 lines takes as long as hundreds of few lines, and shortens as little."""
    monkeypatch.setattr(shorter, "_MOST_KICKED", 4000)
    monkeypatch.setattr(shorter, "_FARTHEST_KICKED", 20)
    kicked, moved, kick, arrange = [], [], shorter._Tour.kick, shorter._Tour._arrange

    def watch_kick(self, chance):
        kicked.append(1)
        kick(self, chance)
        assert self.length == pytest.approx(sum(self._ways), abs=1e-6)

    def watch_arrange(self, low, pieces):
        if self._changes:  # behind a kick, which has moved two pieces
            moved.append(sum(last - first + 1 for first, last, _ in pieces))
        arrange(self, low, pieces)

    monkeypatch.setattr(shorter._Tour, "kick", watch_kick)
    monkeypatch.setattr(shorter._Tour, "_arrange", watch_arrange)
    greedy = sorted_from(field(400, 100), 0j)
    assert ink(shortened(greedy, 0j)) == ink(greedy)
    assert len(kicked) == 10 and moved and max(moved) <= 20 + shorter._LONGEST


@pytest.mark.slow
def test_a_hundred_thousand_lines_take_seconds():
    greedy = sorted_from(field(100_000, 300), 0j)
    begun = time.process_time()
    made = shortened(greedy, 0j)
    assert time.process_time() - begun < 60  # 12; 91 with moves of any length
    assert travel(made, 0j) < 0.78 * travel(greedy, 0j)
