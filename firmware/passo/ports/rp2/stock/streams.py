"""Stands for the module deflate: the stream made last is held, and the next one takes its two pieces of memory, 1.3 kB and the window.

    hold()                                      # before other things take memory
    stream = DeflateIO(file, RAW, 10)
    stream.readinto(first)                      # at once: nothing else is made before the window is
"""

import gc
import sys

import deflate
from deflate import RAW

from passo.records import WINDOW_BITS

_make = deflate.DeflateIO
_held = []


def DeflateIO(file, form, bits):
    """Return a stream as MicroPython's own."""
    made = _make(file, form, bits)
    _held.clear()
    gc.collect()  # the first read takes memory from here on
    _held.append(made)
    return made


def hold():
    """Hold an empty stream with its window, and stand for deflate from here on. Raises MemoryError."""
    from io import BytesIO

    DeflateIO(BytesIO(b"\x03\x00"), RAW, WINDOW_BITS).readinto(bytearray(1))  # no bytes, deflated
    sys.modules["deflate"] = sys.modules[__name__]
