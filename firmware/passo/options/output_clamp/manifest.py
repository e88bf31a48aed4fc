"""An output named `clamp`, or p0_clamp … p9_clamp: it holds the work, and lets it go only on M11."""

RULES = {}


def check(board):
    """Add the feature."""
    board["additions"].features["clamp"] = "passo.options.output_clamp.control", "Clamp"
