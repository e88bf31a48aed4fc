"""The errors, alarms and notices of this option, by number, behind those of passo/errors.py."""

from micropython import const

SQUARED = const(142)
ALARM_GANTRY = const(231)

NOTICE_GANTRY = const(14)  # with both counts
