"""Inputs named `p0` … `p9`: M66 waits for them."""

RULES = {}


def check(board):
    board["additions"].features["wait"] = "passo.options.input_p.control", "Inputs"
