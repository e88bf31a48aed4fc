"""Pieces of memory, made while memory is free in large ones: code leaves small ones only.

    offer([("i", array("i", bytearray(4096)))], 2)      # passo.arrays.zeros(1024) returns this one, once; and two files can be opened

Import it before any module that imports passo.arrays.
"""

import builtins

from micropython import const

from passo import arrays

FILE_BYTES = const(1148)  # of an open file, in one piece, on an RP2040
_open_file = open
_zeros, _numbers, _buffer = arrays.zeros, arrays.numbers, arrays.buffer
_offered = []
_held = []  # pieces, or the files that have taken their places


def offer(pieces, files=0):
    """Offer arrays to who asks for one of their size first. `pieces`: a list of ("i", array) for zeros(), ("I", array) for numbers(), ("b", bytearray)
    for buffer(); it replaces those offered before. `files`: that many more can be opened at any time."""
    _offered.clear()
    _offered.extend(pieces)
    for _ in range(files):
        _held.append(_buffer(FILE_BYTES))
        builtins.open = open_file


def zeros(count):
    """Return an offered array('i') of `count` zeros, or a new one. Raises MemoryError."""
    return _take_piece("i", count) or _zeros(count)


def numbers(count):
    """Return an offered array('I') of `count` numbers, or a new one. Raises MemoryError."""
    return _take_piece("I", count) or _numbers(count)


def buffer(count):
    """Return an offered bytearray of `count` bytes, or a new one. Raises MemoryError."""
    return _take_piece("b", count) or _buffer(count)


def _take_piece(kind, count):
    """Remove and return an offered piece; None if there is none of this length."""
    for index in range(len(_offered)):
        if _offered[index][0] == kind and len(_offered[index][1]) == count:
            return _offered.pop(index)[1]
    return None


def open_file(path, mode="r"):
    """Open a file as the built-in open() does. If memory has no piece for it, it takes one of those that are held. It is held then itself: once it is
    closed, the next file takes its piece."""
    try:
        return _open_file(path, mode)
    except MemoryError:
        pass
    for index in range(len(_held)):
        if _is_free(_held[index]):
            _held[index] = None
            try:
                _held[index] = file = _open_file(path, mode)  # collects garbage
                return file
            except MemoryError:
                pass  # this piece was held by a smaller file: try the next one
    raise MemoryError("no memory for a file")


def _is_free(piece):
    """Return True if a piece is no file, or one that is closed."""
    try:
        piece.flush()
        return False
    except (AttributeError, OSError, ValueError):
        return True


for name, function in (("zeros", zeros), ("numbers", numbers), ("buffer", buffer)):
    setattr(arrays, name, function)
