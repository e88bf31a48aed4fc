"""The errors, alarms and notices of this option, by number, behind those of passo/errors.py."""

from micropython import const

STEPS_MADE_UP = const(140)
POSITION_VERIFIED = const(141)
COUNTS_LOST = const(143)
ALARM_STEPS_MISSING = const(230)

NOTICE_STEPS_MISSING = const(13)  # with which, and where
