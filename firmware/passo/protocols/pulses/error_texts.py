"""The meanings of the numbers of errors.py beside it: see passo/error_texts.py."""

from passo.protocols.pulses.errors import CUT_OFF, NO_CODE, NO_CONTROL, NUMBER_MISSING

TEXTS = {
    NO_CODE: "neither a pulse code nor a command of the language: check the line",
    NUMBER_MISSING: "a number is missing, or unfinished: complete it",
    CUT_OFF: "the file is cut off: fewer or more bytes came than were announced, or none for a while",
    NO_CONTROL: "there is no such control command",
}
