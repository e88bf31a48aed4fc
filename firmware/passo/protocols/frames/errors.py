"""The errors, alarms and notices of this language, by number, behind those of passo/errors.py."""

from micropython import const

FRAME_LATE = const(119)
