"""The errors, alarms and notices of this option, by number, behind those of passo/errors.py."""

from micropython import const

ALARM_DRIVER_SILENT = const(221)
ALARM_DRIVER_DIFFERS = const(222)
ALARM_DRIVER_FAULT = const(223)
ALARM_DRIVER_POWER = const(224)
