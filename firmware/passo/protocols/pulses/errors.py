"""The errors, alarms and notices of this language, by number, behind those of passo/errors.py."""

from micropython import const

NO_CODE = const(120)
NUMBER_MISSING = const(121)
CUT_OFF = const(123)
NO_CONTROL = const(124)
