"""The fields of Switches.marks, by name: as passo/records.py. First how many changes were asked for and shown, for ever, modulo 2²⁹."""

from micropython import const

SWITCH_ASKED = const(0)
SWITCH_SHOWN = const(1)
SWITCH_PULSES = const(2)  # mask of a word's pulses
SWITCH_STRIDE = const(3)  # integers a row of the planner
SWITCH_FIRST = const(4)  # then a ring of them
SWITCH_MOST = const(16)  # a power of two
# A change:
SWITCH_BLOCK = const(0)  # count of the block that it begins with
SWITCH_WORD = const(1)  # count of that block's first word that steps, modulo 2²⁹; SWITCH_NEVER: not known yet
SWITCH_VALUE = const(2)  # pin << 1 | level
SWITCH_FIELDS = const(3)
SWITCH_NEVER = const(0x20000000)
