"""The errors, alarms and notices of this option, by number, behind those of passo/errors.py."""

from micropython import const

NO_STEP_PROGRAM = const(125)
STEP_PROGRAM_FULL = const(126)
RETURN_OR_CONTINUE = const(127)
PASSES = const(128)
DRIVES_OFF = const(130)
