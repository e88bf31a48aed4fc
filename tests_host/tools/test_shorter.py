"""Shorter ways: the same ink, no longer a way, closed lines entered anywhere, the same order every time, with and without a compiler."""

import random
import time

import numpy
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from host_tools.build import pc_kernels
from host_tools.drawings import order_viper, shorter
from host_tools.drawings.line_order import travel_length
from host_tools.drawings.shorter import shorten

POINTS = st.builds(complex, st.integers(0, 100), st.integers(0, 100))
OPEN = st.lists(POINTS, min_size=2, max_size=5).map(numpy.array)
CLOSED = st.lists(POINTS, min_size=3, max_size=6).map(lambda places: numpy.array([*places, places[0]]))
MANY = st.lists(st.one_of(OPEN, CLOSED), max_size=40)
needs_compiler = pytest.mark.skipif(pc_kernels.compiler_command() is None, reason="there is no C compiler for this PC")


@pytest.fixture
def in_c(monkeypatch):
    monkeypatch.setenv(pc_kernels.CHOICE, "c")


def ink(lines):
    return sorted(tuple(sorted(((a.real, a.imag), (b.real, b.imag)))) for line in lines for a, b in zip(line, line[1:]))


def greedy(lines, place):
    """Always the nearest end next, as vpype's linesort takes them."""
    lines, made = [numpy.asarray(line) for line in lines], []
    ends = numpy.array([[line[0], line[-1]] for line in lines])
    for _ in range(len(lines)):
        nearest = int(numpy.argmin(abs(ends - place)))
        made.append(lines[nearest // 2][:: -1 if nearest % 2 else 1])
        place, ends[nearest // 2] = made[-1][-1], numpy.inf
    return made


@settings(deadline=None)
@given(MANY, POINTS)
def test_the_same_ink_on_no_longer_a_way(lines, place):
    made = shorten(lines, place)
    assert len(made) == len(lines) and ink(made) == ink(lines)
    assert travel_length(made, place) <= travel_length(lines, place) + 1e-6
    for line in made:
        assert any(len(line) == len(each) and ink([line]) == ink([each]) for each in lines)
    again = shorten(lines, place)
    assert all((a == b).all() for a, b in zip(made, again))


@needs_compiler
@settings(deadline=None, max_examples=40)
@given(MANY, POINTS)
def test_c_gives_the_same_order(lines, place):
    """With as many tries as in C."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shorter, "_KICKS_A_LINE", 2)
        patch.setattr(shorter, "_STARTS", 3)
        patch.setattr(shorter, "_PLAIN", 1)
        plain = shorten(lines, place)
        patch.setenv(pc_kernels.CHOICE, "c")
        assert [line.tolist() for line in shorten(lines, place)] == [line.tolist() for line in plain]


@settings(deadline=None)
@given(st.lists(st.tuples(*[st.integers(0, 30)] * 4), min_size=1, max_size=60), st.integers(0, 3))
def test_the_nearest_end_is_next(places, near):
    """As in a search of all ends, whether it is in the grid's rings or found in a search of all that are left. Near ones are left aside:
    they are the nearest on two curves, which is not always the nearest."""
    spread = [1, 40, 400, 1092][near]
    lines = [numpy.array([complex(a, b), complex(c, d)]) * spread for a, b, c, d in places]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shorter, "_nearest_ends", lambda xs, ys: numpy.full(len(xs) * order_viper.NEAR, -1))
        patch.setattr(shorter, "travel_length", lambda lines, place: 0.0)  # the file's order is not taken because it is shorter
        patch.setattr(shorter, "_SIDE", 30 * spread)
        tour = shorter._Tour([*lines, numpy.array([0j, 30 * spread * (1 + 1j)])], 0j)  # one unit is 1
        tour.start()
        took = [end for end in tour._tour_order()]
    at = 2 * len(tour._lines)
    left = set(range(2 * len(tour._lines)))
    for end in took:
        assert order_viper.apart(tour._xs, tour._ys, at, int(end)) == min(order_viper.apart(tour._xs, tour._ys, at, other) for other in left)
        left -= {int(end), int(end) ^ 1}
        at = int(end) ^ 1


def test_a_closed_line_is_entered_where_it_suits():
    square = numpy.array([0, 10, 10 + 10j, 10j, 0])
    (line,) = shorten([square], 11 + 11j)
    assert line[0] == line[-1] == 10 + 10j and ink([line]) == ink([square])
    made = shorten([square, numpy.array([12 + 10j, 20 + 10j])], -1 + 10j)
    assert travel_length(made, -1 + 10j) <= 1 + abs(12 + 10j - 10j) + 1e-9


@needs_compiler
@pytest.mark.parametrize("closed, share", [(False, 0.765), (True, 0.71)])
def test_a_field_of_lines_takes_a_quarter_less_than_greedy(closed, share, in_c):
    """Greedy is what vpype's linesort does; its two-opt takes a sixth off a field of lines."""
    chance = random.Random(3)

    def one():
        x, y = complex(chance.uniform(0, 1000), chance.uniform(0, 1000)), complex(chance.uniform(-15, 15), chance.uniform(-15, 15))
        return x + y * numpy.exp(2j * numpy.pi * numpy.arange(13) / 12) if closed else numpy.array([x, x + y])

    lines = [one() for _ in range(800)]
    if closed:
        lines = [numpy.append(line[:-1], line[0]) for line in lines]
    assert travel_length(shorten(lines, 0j), 0j) < share * travel_length(greedy(lines, 0j), 0j)


def field(count, side):
    chance = random.Random(3)
    places = [complex(chance.uniform(0, side), chance.uniform(0, side)) for _ in range(count)]
    return [numpy.array([place, place + complex(chance.uniform(-3, 3), chance.uniform(-3, 3))]) for place in places]


def test_without_a_compiler_there_are_fewer_tries(monkeypatch):
    """Else the time would be a hundred times as long; the way is still shorter than greedy's."""
    lines, counts = field(300, 100), []
    kick = shorter._Tour.kick_tour
    monkeypatch.setattr(shorter._Tour, "kick_tour", lambda self, *given: kick(self, *given) or counts.append(self._state[order_viper.TRIED]))
    shares = []
    made = shorten(lines, 0j, shares.append)
    assert ink(made) == ink(lines) and travel_length(made, 0j) < 0.85 * travel_length(greedy(lines, 0j), 0j)
    assert counts[0] < shorter._MOST_TRIED // shorter._PLAIN + 50_000 and shares[0] == 0 and shares == sorted(shares) and shares[-1] <= 1


def test_a_move_takes_no_more_lines_along_than_it_may(monkeypatch):
    """Else the time is that of the square of the lines."""
    monkeypatch.setattr(shorter, "_FARTHEST", 50)
    monkeypatch.setattr(shorter, "_KICKS", 0)
    moved, turn = [], order_viper.reverse_lines
    monkeypatch.setattr(order_viper, "reverse_lines", lambda state, tour, at, log, low, high: moved.append(high - low + 1) or turn(state, tour, at, log, low, high))
    lines = greedy(field(1500, 100), 0j)
    made = shorten(lines, 0j)
    assert ink(made) == ink(lines) and travel_length(made, 0j) < 0.95 * travel_length(lines, 0j)
    assert len(moved) > 100 and max(moved) <= 50 + order_viper.LONGEST


def test_a_kick_that_does_not_help_is_taken_back():
    """Its turns are undone in the opposite order; the sum of ways stays that of the tour."""
    tour = shorter._Tour(field(60, 100), 0j)
    tour.start()
    tour.improve_tour(lambda share: None)
    state, way = tour._state, lambda: sum(
        order_viper.apart(tour._xs, tour._ys, tour._tour[index] ^ 1, tour._tour[index + 1]) for index in range(60)
    )
    begun, length = way(), state[order_viper.LENGTH]
    state[order_viper.FARTHEST] = 1000
    took_back = 0
    for _ in range(60):
        before, order = way(), tour._tour.tolist()
        order_viper.kick_once(*tour._move_arrays)
        assert way() - begun == state[order_viper.LENGTH] - length and way() <= before
        assert all(tour._at[end >> 1] == index + 1 for index, end in enumerate(tour._tour_order()))
        took_back += tour._tour.tolist() == order
    assert took_back > 10


@needs_compiler
@pytest.mark.parametrize("heap", [False, True])
def test_eight_thousand_lines_take_a_second(heap, in_c):
    """Also if all but one lie in one heap, where a grid over the whole would have them in one cell."""
    lines = field(8000, 300)
    if heap:
        lines = [line / 1000 for line in lines] + [numpy.array([299 + 299j, 300 + 300j])]
    shorten(lines[:10], 0j)  # the kernels are made
    begun = time.process_time()
    made = shorten(lines, 0j)
    assert time.process_time() - begun < 10  # 1; in Python, with as many tries, 150
    assert ink(made) == ink(lines)


@needs_compiler
@pytest.mark.slow
def test_a_hundred_thousand_lines_take_seconds(in_c):
    lines = field(100_000, 300)
    begun = time.process_time()
    made = shorten(lines, 0j)
    assert time.process_time() - begun < 20  # 2
    assert travel_length(made, 0j) < 46_700  # 1.29 times as much by the nearest end alone
