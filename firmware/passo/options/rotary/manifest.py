"""The key `rotary`: the axis that turns. Only loaded if the board file has it."""

from passo.config.board_error import BoardError

HEAP_KB = 5  # of a Pico with stock MicroPython
RULES = {
    "rotary": ("a",),  # the axis; its millimetres are degrees, and a metre is a thousand of them
    "short_way": (bool, False, 0, 1),  # an absolute word leads by half a turn at most
}


def check(board):
    """Check axes and links; add the queue. Raises BoardError."""
    board["additions"].queue = "passo.options.rotary.control"
    if "".join([axis["name"] for axis in board["axes"]]) != "xyza":
        raise BoardError("rotary: axes x, y, z, a are wanted")
    if "grbl" not in [link["protocol"] for link in board["links"]]:
        raise BoardError("rotary: a link that speaks grbl is wanted")
