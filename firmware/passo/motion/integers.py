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


_kept = []  # see keep()


def keep(kept):
    """`kept`: a list of what was made while memory was free in large pieces: ("i", array) for zeros(), ("I", array) for numbers(),
    and what only keeps a piece free. If there is no room for another array they are given back, the last first; [] forgets them."""
    _kept.clear()
    _kept.append(kept)


def _make(kind, how, count):
    kept = _kept[0] if _kept else ()
    for place in range(len(kept)):
        piece = kept[place]
        if piece and piece[0] == kind and len(piece[1]) == count:
            kept[place] = b""
            return piece[1]
    while True:
        try:
            return how(count)
        except MemoryError:
            for place in range(len(kept) - 1, -1, -1):
                if kept[place]:
                    kept[place] = b""  # not by pop(): what it returns stays on the interpreter's stack, and is not collected
                    break
            else:
                raise


def zeros(count):
    """An array('i') of `count` zeros."""
    return _make("i", _zeros, count)


def numbers(count):
    """An array('I') of `count` numbers."""
    return _make("I", _counted, count)


# Both are made in one piece of memory: from a list or bytes an array would take two.


def _counted(count):
    return array("I", range(count))


def _zeros(count):
    made = array("i", range(count))
    part = array("i", bytearray(4 * _PART))
    for at in range(0, count, _PART):
        made[at : at + _PART] = part[: min(_PART, count - at)]
    return made
