"""The key `blackbox`: what leads to an alarm or a crash is kept."""

from passo.options.blackbox.config import BOX_ADDED, BOX_MAGIC_0, BOX_MAGIC_1, BOX_NUMBERS, BOX_TEXT, BOX_WRITTEN, keep

RULES = {
    "blackbox": (bool, False, 0, 1),
    "features": (dict, {}, 0, 16),  # set by check(): (module, class) by the name of a feature, see machine_builder.rows()
    # set by check(): the module whose keep() finds at the start what a reset has left, and what that wants. A word that all boards have in memory
    "keep": (tuple, (), 0, 8),
}


def check(board):
    if board["blackbox"]:
        board["features"]["links"] = "passo.options.blackbox.control", "Links"
        if board["chip"][:2] == "rp":
            sizes = 4 * BOX_NUMBERS, BOX_TEXT, 4 * BOX_ADDED, 4 * BOX_WRITTEN
            board["keep"] = ("passo.options.blackbox.port_rp2", keep, BOX_MAGIC_0, BOX_MAGIC_1) + sizes
