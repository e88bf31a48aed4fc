"""The meanings of the numbers of errors.py beside it: see passo/error_texts.py."""

from passo.options.encoders.errors import ALARM_STEPS_MISSING, COUNTS_LOST, POSITION_VERIFIED, STEPS_MADE_UP

TEXTS = {
    STEPS_MADE_UP: "an encoder missed steps at the end of a move, and they were made up for: the log says how many",
    POSITION_VERIFIED: "after a halt the encoders have told the position: it is known again",
    COUNTS_LOST: "an encoder's index pulse came elsewhere than whole turns from the first: the encoder lost counts, or counted noise",
    ALARM_STEPS_MISSING: "an encoder says that steps are missing, or too many: the log says how many, and where",
}
