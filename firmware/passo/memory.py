"""Large arrays, each in one piece of memory, made while there are pieces as large.

    keep([("i", array("i", bytearray(4096)))])      # at the start, before code is loaded: it leaves small pieces only
    zeros(1024)                                     # this one
"""

from array import array

from micropython import const

_PART = const(128)
_kept = []  # see keep()


def keep(kept):
    """`kept`: a list of what was made while memory was free in large pieces: ("i", array) for zeros(), ("I", array) for
    numbers(), ("n", list) for room(), and lists that only keep a piece free. If there is no room for another array they are
    given back, the last first; [] forgets them."""
    _kept.clear()
    _kept.append(kept)


def zeros(count):
    """An array('i') of `count` zeros."""
    return _make("i", _zeros, count)


def numbers(count):
    """An array('I') of `count` numbers."""
    return _make("I", _counted, count)


def room(count):
    """A list that keeps memory for `count` words free, until clear() gives it back at once."""
    return _make("n", _nothing, count)


def _make(kind, how, count):
    kept = _kept[0] if _kept else ()
    for place in range(len(kept)):
        piece = kept[place]
        if piece and piece[0] == kind and len(piece[1]) == count:
            kept[place] = ()
            return piece[1]
    while True:
        try:
            return how(count)
        except MemoryError:
            for place in range(len(kept) - 1, -1, -1):
                if kept[place]:
                    if isinstance(kept[place], list):
                        kept[place].clear()  # at once; an array waits for the collector, and a stale word on the stack may keep it
                    else:
                        kept[place] = ()
                    break
            else:
                raise


# In one piece of memory: from a list or bytes an array would take two.


def _counted(count):
    return array("I", range(count))


def _zeros(count):
    made = array("i", range(count))
    part = array("i", bytearray(4 * _PART))
    for at in range(0, count, _PART):
        made[at : at + _PART] = part[: min(_PART, count - at)]
    return made


def _nothing(count):
    return [None] * count
