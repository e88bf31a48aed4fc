"""The meanings of the numbers of errors.py beside it: see passo/error_texts.py."""

from passo.options.inverter.errors import ALARM_INVERTER_FAULT, ALARM_INVERTER_GARBLED, ALARM_INVERTER_LATE, ALARM_INVERTER_REFUSED, ALARM_INVERTER_SILENT

TEXTS = {
    ALARM_INVERTER_SILENT: "the spindle's inverter does not answer: check its power, wires, baud rate and address",
    ALARM_INVERTER_GARBLED: "replies of the spindle's inverter are garbled: check shield, termination and baud rate",
    ALARM_INVERTER_FAULT: "the spindle's inverter has a fault: the log has its number; clear it there",
    ALARM_INVERTER_REFUSED: "the spindle's inverter refused a request: check its make, and that it takes commands from its serial line",
    ALARM_INVERTER_LATE: "replies of the spindle's inverter come late: raise timeout_ms of the board file, or shorten the delay of its replies there",
}
