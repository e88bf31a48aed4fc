"""Inputs named `p0` … `p9`: M66 waits for them."""

RULES = {}


def check(board):
    """Add the feature."""
    board["additions"].features["wait"] = "passo.options.input_p.control", "Inputs"
