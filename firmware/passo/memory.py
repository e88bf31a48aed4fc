"""Large arrays, each in one piece of memory, made while there are pieces as large; and pieces kept for later.

    keep([("i", array("i", bytearray(4096)))])      # at the start, before code is loaded: it leaves small pieces only
    zeros(1024)                                     # this one
    room = FileRoom()
    file = room.open(path, "rb")                    # takes the piece that has been kept
    file.close()
    file = None
    room.keep()
"""

import gc
import sys
from array import array

from micropython import const

_PART = const(128)
FILE_BYTES = const(1148)  # of an open file, in one piece, on an RP2040
_NAME_BYTES = const(48)  # bytes that open() takes before the file: a copy of its name
WINDOW_BITS = const(10)
_kept = []  # see keep()


def keep(kept):
    """Keep pieces for later. `kept`: a list of the arrays made while memory was free in large pieces: ("i", array) for zeros(), ("I", array) for
    numbers(), ("b", bytearray) for buffer() and a FileRoom, ("d", DeflateIO) for stream(); () forgets them."""
    _kept.clear()
    _kept.append(kept)


def zeros(count):
    """Return an array('i') of `count` zeros, in one piece of memory. Raises MemoryError."""
    made = _take_piece("i", count)
    if not made:
        made = array("i", range(count))  # in one piece of memory, as below: from a list or bytes an array would take two
        part = array("i", bytearray(4 * _PART))
        for at in range(0, count, _PART):
            made[at : at + _PART] = part[: min(_PART, count - at)]
    return made


def numbers(count):
    """Return an array('I') of `count` numbers, whose values do not matter. Raises MemoryError."""
    return _take_piece("I", count) or array("I", range(count))


def buffer(count):
    """Return a bytearray of `count` bytes. Raises MemoryError."""
    return _take_piece("b", count) or bytearray(count)


def stream():
    """Return a DeflateIO that has been read to its end: it holds the two pieces that another one will take. None without memory."""
    try:
        return _take_piece("d", 0) or empty_stream(0)
    except MemoryError:
        return None


def forget(name, empty=False):
    """Give back the memory of a module that only the start needs; if it is imported again, it is loaded again. `empty`: on a Pico, clear
    its globals too, because a stale word on the stack that points to one of its functions would keep all of them. Default: False,
    for a module whose functions are still used."""
    module = sys.modules.pop(name, None)
    if module:
        package, _, short = name.rpartition(".")
        if package:
            delattr(sys.modules[package], short)
        if empty and sys.platform == "rp2":
            module.__dict__.clear()


class FileRoom:
    """Keeps memory for a file that is opened later, at a stand: a board that has run for a while may have no such piece."""

    none = False  # see spare()

    @classmethod
    def spare(cls):
        """Keep no piece from here on: enough memory stays free for one at any time."""
        cls.none = True

    def __init__(self):
        self._kept = None  # until keep() is called first
        self._name = None

    def open(self, path, mode):
        """Open a file. Its errors leave no room: call keep() then, too."""
        self._kept = self._name = None
        gc.collect()  # open() alone takes memory from here on
        return open(path, mode)

    def keep(self):
        """Keep a piece for the next file. Call it when the file is closed and nothing points to it any more."""
        self._kept = self._name = None
        gc.collect()
        if self.none:
            return
        try:
            self._name = bytearray(_NAME_BYTES)  # made first, it lies lower: so will the copy of the name, not where the file is to be
            self._kept = buffer(FILE_BYTES)
        except MemoryError:
            pass  # the next file may find some


def _take_piece(kind, count):
    """Remove and return a piece of keep(); `count` 0: of any length. None if there is none."""
    kept = _kept[0] if _kept else ()
    for index in range(len(kept)):
        piece = kept[index]
        if piece and piece[0] == kind and (not count or len(piece[1]) == count):
            kept[index] = ()
            return piece[1]
    return None


def empty_stream(_):
    """Return a DeflateIO at the end of an empty stream. Raises MemoryError."""
    from io import BytesIO

    import deflate

    made = deflate.DeflateIO(BytesIO(b"\x03\x00"), deflate.RAW, WINDOW_BITS)  # no bytes, deflated
    made.readinto(bytearray(1))
    return made
