"""The errors, alarms and notices of this option, by number, behind those of passo/errors.py."""

from micropython import const

ALARM_INTERLOCK = const(220)
