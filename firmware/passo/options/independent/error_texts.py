"""The meanings of the numbers of errors.py beside it: see passo/error_texts.py."""

from passo.options.independent.errors import ZERO_IS_HOMED

TEXTS = {
    ZERO_IS_HOMED: "machine zero is where homing found it: it cannot be set elsewhere",
}
