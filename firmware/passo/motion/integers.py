"""Integer mathematics that MicroPython's `math` lacks. Big integers are welcome, but in divide(): once a block."""

from array import array

import micropython
from micropython import const

from passo.records import NM_PER_M

_PART = const(128)


def isqrt(value):
    """Floor of the square root of `value` ≥ 0, by Newton's iteration from above."""
    if value < 0:
        raise ValueError("square root of a negative number")
    if value < 2:
        return value
    root = 1
    while root * root < value:
        root <<= 1
    while True:
        better = (root + value // root) >> 1
        if better >= root:
            return root
        root = better


def length_nm(deltas, steps_per_m):
    """Euclidean length, in nanometres, of a vector of steps on axes of `steps_per_m` each."""
    total = 0
    for delta, resolution in zip(deltas, steps_per_m):
        along = abs(delta) * NM_PER_M // resolution
        total += along * along
    return isqrt(total)


@micropython.viper
def divide(value: int, by: int, bits: int) -> int:  # ISR: no allocation
    """value · 2ᵇⁱᵗˢ // by, the quotient below 2³⁰, for 0 < by < 2²²."""
    quotient = value // by
    rest = value % by
    while bits > 0:
        some = bits if bits < 8 else 8
        rest <<= some
        quotient = (quotient << some) + rest // by
        rest %= by
        bits -= some
    return quotient


_rooms = []  # see keep()


def keep(rooms):
    """`rooms`: a list of what keeps memory free in large pieces. One after the other is given back if there is no room for an
    array of zeros() or numbers()."""
    _rooms.clear()
    _rooms.append(rooms)


def _make(how, count):
    while True:
        try:
            return how(count)
        except MemoryError:
            if not _rooms or not _rooms[0]:
                raise
            _rooms[0].pop()


def zeros(count):
    """An array('i') of `count` zeros."""
    return _make(_zeros, count)


def numbers(count):
    """An array('I') of the numbers from 0 to `count` - 1."""
    return _make(_counted, count)


# Both are made in one piece of memory: from a list or bytes an array would take two.


def _counted(count):
    return array("I", range(count))


def _zeros(count):
    made = array("i", range(count))
    part = array("i", bytearray(4 * _PART))
    for at in range(0, count, _PART):
        made[at : at + _PART] = part[: min(_PART, count - at)]
    return made
