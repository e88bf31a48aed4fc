"""The meanings of the numbers of errors.py beside it: see passo/error_texts.py."""

from passo.options.interlock.errors import ALARM_INTERLOCK

TEXTS = {
    ALARM_INTERLOCK: "the interlock has stopped the machine: the log names the input; the position may be lost",
}
