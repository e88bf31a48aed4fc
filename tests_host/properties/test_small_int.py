"""The narrow integer catches what a board would allocate for."""

import operator

import pytest

from small_int import HIGH, LOW, Small

pytestmark = pytest.mark.quick

OPERATORS = [getattr(operator, name) for name in ("add", "sub", "mul", "floordiv", "mod", "and_", "or_", "xor")]


@pytest.mark.parametrize("operate", OPERATORS)
@pytest.mark.parametrize("left, right", [(Small(700), Small(-3)), (Small(700), -3), (700, Small(-3))])
def test_results_stay_small_and_right(operate, left, right):
    result = operate(left, right)
    assert type(result) is Small
    assert result == operate(700, -3)


def test_shifts_and_unary():
    assert type(Small(3) << 4) is Small and Small(3) << 4 == 48
    assert type(48 >> Small(4)) is Small and 48 >> Small(4) == 3
    assert [type(value) for value in (-Small(1), +Small(1), abs(Small(-1)), ~Small(1))] == [Small] * 4
    assert divmod(Small(7), 2) == (3, 1) and type(divmod(Small(7), 2)[0]) is Small


def test_augmented_assignment():
    value = Small(HIGH - 1)
    value += 1
    assert type(value) is Small
    with pytest.raises(OverflowError):
        value += 1


@pytest.mark.parametrize(
    "overflow",
    [
        lambda: Small(HIGH) + 1,
        lambda: Small(LOW) - 1,
        lambda: -Small(LOW),
        lambda: Small(1 << 16) * (1 << 14),
        lambda: 1 << Small(30),
        lambda: Small(1) << 30,
        lambda: Small(0) | 0xFFFFFFFF,
        # The sum overflows although the masked result would fit.
        lambda: (Small(HIGH) + Small(HIGH)) & HIGH,
        lambda: Small(HIGH + 1),
    ],
)
def test_overflow_raises(overflow):
    with pytest.raises(OverflowError):
        overflow()


def test_ends_are_small():
    assert Small(HIGH - 1) + 1 == HIGH
    assert Small(LOW + 1) - 1 == LOW


def test_true_division_raises():
    with pytest.raises(TypeError):
        Small(4) / 2
    with pytest.raises(TypeError):
        4 / Small(2)


def test_indexes_and_compares_like_an_int():
    assert [10, 20, 30][Small(1)] == 20
    assert Small(3) < 4 and hash(Small(3)) == hash(3)
