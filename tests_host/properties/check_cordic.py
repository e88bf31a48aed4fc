"""CORDIC: a point turned within one step of the true one for radii to 2²⁰ and any angle; angles and lengths of vectors."""

from math import atan2, cos, pi, sin, sqrt

from passo.motion import cordic
from passo.motion.cordic import PI_64, QUARTER, TURN, arc_length, rotate, vector

CASES = {
    "check_end_point": (("x", -(1 << 20), 1 << 20), ("y", -(1 << 20), 1 << 20), ("sweep", -4 * TURN, 4 * TURN)),
    "check_small_radii": (("x", -60, 60), ("y", -60, 60), ("sweep", 0, TURN - 1)),
    "check_near_the_octants": (("radius", 1, 1 << 20), ("eighth", 0, 7), ("off", -40, 40)),
    "check_vector": (("x", -(1 << 20), 1 << 20), ("y", -(1 << 20), 1 << 20)),
    "check_there_and_back": (("x", -(1 << 20), 1 << 20), ("y", -(1 << 20), 1 << 20), ("sweep", 0, TURN - 1)),
}
RUNS = {"check_end_point": 300, "check_small_radii": 300, "check_vector": 200}


def distance(x, y, sweep):
    """From the point turned to the true one, in steps."""
    angle = (sweep % TURN) * 2 * pi / TURN
    got = rotate(x, y, sweep)
    return sqrt((got[0] - x * cos(angle) + y * sin(angle)) ** 2 + (got[1] - x * sin(angle) - y * cos(angle)) ** 2)


def check_end_point(x, y, sweep):
    assert distance(x, y, sweep) < 0.9


def check_small_radii(x, y, sweep):
    assert distance(x, y, sweep) < 0.9


def check_near_the_octants(radius, eighth, off):
    assert distance(radius, 0, eighth * (TURN // 8) + off) < 1
    assert distance(-radius, radius // 2, eighth * (TURN // 8) + off) < 1


def check_quarters_are_exact():
    for turns in range(-3, 4):
        assert rotate(1000000, -3, turns * TURN) == (1000000, -3)
        assert rotate(1000000, -3, turns * TURN + QUARTER) == (3, 1000000)
        assert rotate(1000000, -3, turns * TURN - QUARTER) == (-3, -1000000)


def check_vector(x, y):
    angle, length = vector(x, y)
    if not (x or y):
        assert angle == length == 0
        return
    assert 0 <= angle < TURN
    assert abs(length - sqrt(x * x + y * y)) < 0.51
    off = (angle - atan2(y, x) / (2 * pi) * TURN + TURN / 2) % TURN - TURN / 2
    assert abs(off) < 2


def check_there_and_back(x, y, sweep):
    there = rotate(x, y, sweep)
    back = rotate(there[0], there[1], -sweep)
    assert max(abs(back[0] - x), abs(back[1] - y)) <= 2


def check_pi():
    assert abs(PI_64 / (1 << 64) - pi) < 1e-15
    assert arc_length(1 << 20, TURN) == int(2 * pi * (1 << 20) + 0.5)


def atan_of_inverse(n):
    """atan(1/n), n ≥ 2, in 2⁻⁶⁴, by Gregory's series."""
    total = power = (1 << 64) // n
    k = 3
    while power:
        power //= n * n
        total += power // k if k & 2 == 0 else -(power // k)
        k += 2
    return total


def check_constants():
    """They are what their definitions say: π by Machin's formula, each angle to its last bit."""
    assert PI_64 == 4 * (4 * atan_of_inverse(5) - atan_of_inverse(239))
    count = len(cordic._ANGLES)
    angles = [((atan_of_inverse(1 << i) << 40) + PI_64) // (2 * PI_64) for i in range(1, count)]
    assert cordic._ANGLES == tuple([1 << 37] + angles) and count == 36
    square = 1 << 80
    for i in range(count):
        square = (square << 2 * i) // ((1 << 2 * i) + 1)
    assert cordic._INVERSE_GAIN ** 2 <= square < (cordic._INVERSE_GAIN + 1) ** 2
