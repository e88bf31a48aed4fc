"""The key `blackbox`: a record of the time before an alarm or a crash."""

from passo.options.blackbox.config import BOX_ADDED, BOX_MAGIC_0, BOX_MAGIC_1, BOX_NUMBERS, BOX_TEXT, BOX_WRITTEN, write_box

HEAP_KB = 15  # of a Pico with stock MicroPython
RULES = {
    "blackbox": (bool, False, 0, 1),
}


def check(board):
    """Have the black box stand in for the feature links; on an rp2 chip a box in memory is written at the start."""
    if board["blackbox"]:
        board["additions"].features["links"] = "passo.options.blackbox.control", "Links"
        if board["chip"][:2] == "rp":
            sizes = 4 * BOX_NUMBERS, BOX_TEXT, 4 * BOX_ADDED, 4 * BOX_WRITTEN
            board["additions"].box = ("passo.options.blackbox.port_rp2", write_box, BOX_MAGIC_0, BOX_MAGIC_1) + sizes
