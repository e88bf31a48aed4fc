"""The meanings of the numbers of errors.py beside it: see passo/error_texts.py."""

from passo.options.gantry.errors import ALARM_GANTRY, SQUARED

TEXTS = {
    SQUARED: "a motor of the gantry was behind, and was stepped alone: the log says which, and by how many steps",
    ALARM_GANTRY: "the two motors of the gantry are too far apart: the log names both counts",
}
