"""The errors, alarms and notices of this option, by number, behind those of passo/errors.py."""

from micropython import const

SPINDLE_TURNS = const(132)
