"""An output named `vacuum`, or p0_vacuum … p9_vacuum: a vacuum cleaner that G-code switches."""

RULES = {}


def check(board):
    """Add the feature."""
    board["additions"].features["vacuum"] = "passo.options.output_vacuum.control", "Vacuum"
