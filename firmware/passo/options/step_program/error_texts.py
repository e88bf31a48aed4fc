"""The meanings of the numbers of errors.py beside it: see passo/error_texts.py."""

from passo.options.step_program.errors import DRIVES_OFF, NO_STEP_PROGRAM, PASSES, RETURN_OR_CONTINUE, STEP_PROGRAM_FULL

TEXTS = {
    NO_STEP_PROGRAM: "there is no step program: load one first",
    STEP_PROGRAM_FULL: "the step program is too long to be stored: stream it",
    RETURN_OR_CONTINUE: "moved by hand: return the way back, or continue from here",
    PASSES: "a step program is repeated 1 … 100 times",
    DRIVES_OFF: "the drives have been switched off by hand: switch them on first",
}
