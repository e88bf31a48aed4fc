"""The meanings of the numbers of errors.py beside it: see passo/error_texts.py."""

from passo.protocols.frames.errors import FRAME_LATE

TEXTS = {
    FRAME_LATE: "a frame came on a link that has left frames, and was dropped",
}
