"""An output named `vacuum`, or p0_vacuum … p9_vacuum: a vacuum cleaner that G-code switches."""

RULES = {}


def check(board):
    board["additions"].features["vacuum"] = "passo.options.output_vacuum.control", "Vacuum"
