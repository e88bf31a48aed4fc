"""Arrays, each in one piece of memory: zeros(1024) is an array('i'), numbers(1024) an array('I'), buffer(1024) a bytearray."""

from array import array

from micropython import const

_PART = const(128)


def zeros(count):
    """Return an array('i') of `count` zeros. Raises MemoryError."""
    made = array("i", range(count))  # in one piece of memory, as below: from a list or bytes an array would take two
    part = array("i", bytearray(4 * _PART))
    for at in range(0, count, _PART):
        made[at : at + _PART] = part[: min(_PART, count - at)]
    return made


def numbers(count):
    """Return an array('I') of `count` numbers, whose values do not matter. Raises MemoryError."""
    return array("I", range(count))


def buffer(count):
    """Return a bytearray of `count` bytes. Raises MemoryError."""
    return bytearray(count)
