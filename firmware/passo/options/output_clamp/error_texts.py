"""The meanings of the numbers of errors.py beside it: see passo/error_texts.py."""

from passo.options.output_clamp.errors import SPINDLE_TURNS

TEXTS = {
    SPINDLE_TURNS: "the work is not let go while the spindle turns: M5 first",
}
