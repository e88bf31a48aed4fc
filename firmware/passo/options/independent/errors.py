"""The errors, alarms and notices of this option, by number, behind those of passo/errors.py."""

from micropython import const

ZERO_IS_HOMED = const(114)
