"""The contents of a black box: its numbers, as control.py fills them, and the file that they are written to."""

import os
import sys

from micropython import const

# Fields of the numbers, and sizes.
BOX_MAGIC_0 = const(0x0B0A3C91)
BOX_MAGIC_1 = const(0x1C5E77D2)
BOX_SIZE = const(2)
BOX_BASE = const(3)
BOX_ADDED = const(4)
BOX_TAKEN = const(5)
BOX_WRITTEN = const(6)
BOX_AT = const(7)
BOX_END = const(8)
BOX_SAMPLED = const(9)
BOX_HEAD = const(10)
BOX_ROWS = const(32)
BOX_SAMPLES = const(20)  # rows, behind those
BOX_ROW = const(9)
BOX_FIRST = const(478)  # snapshot: behind the rows
BOX_SNAPSHOTS = const(6)
BOX_SNAPSHOT = const(56)
BOX_NUMBERS = const(814)  # of all
BOX_TEXT = const(6144)  # bytes of the text

NAME, OLD = "blackbox.bin", "blackbox.old"  # the newest two
_PART = 1024


def box_head(why):
    """Return the first line of a box; `why`: alarm, end or reset."""
    return ("passo blackbox 2 %s %s\n" % (sys.platform, why)).encode()


def write_box(why, numbers, text, feed=None):
    """Write a box to flash, in place of the older of two. `feed()`: the watchdog's, called once a kilobyte. Raises OSError."""
    for how in (lambda: os.remove(OLD), lambda: os.rename(NAME, OLD)):
        try:
            how()
        except OSError:
            pass
    with open(NAME, "wb") as file:
        file.write(box_head(why))
        for data in (numbers, text):
            for at in range(0, len(data), _PART):
                if feed:
                    feed()
                file.write(data[at : at + _PART])
