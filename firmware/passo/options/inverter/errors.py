"""The errors, alarms and notices of this option, by number, behind those of passo/errors.py."""

from micropython import const

ALARM_INVERTER_SILENT = const(240)
ALARM_INVERTER_GARBLED = const(241)
ALARM_INVERTER_FAULT = const(242)
ALARM_INVERTER_REFUSED = const(243)
ALARM_INVERTER_LATE = const(245)
