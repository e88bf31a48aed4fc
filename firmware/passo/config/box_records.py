"""The numbers of a black box, see control/blackbox.py: fields, and sizes. Only boards that have one load it."""

from micropython import const

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
