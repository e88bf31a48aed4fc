"""The meanings of the numbers of errors.py beside it: see passo/error_texts.py."""

from passo.options.drivers.errors import ALARM_DRIVER_DIFFERS, ALARM_DRIVER_FAULT, ALARM_DRIVER_POWER, ALARM_DRIVER_SILENT

TEXTS = {
    ALARM_DRIVER_SILENT: "a driver is silent: check wire, address, power",
    ALARM_DRIVER_DIFFERS: "a driver is another chip, or differs",
    ALARM_DRIVER_FAULT: "a driver overheated or shorted: check motor",
    ALARM_DRIVER_POWER: "a driver lost its power: home",
}
