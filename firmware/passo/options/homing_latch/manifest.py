"""`homing.latch` True: how well homing repeats is judged."""

RULES = {}


def check(board):
    """Add the feature."""
    board["additions"].features["quality"] = "passo.options.homing_latch.control", "Quality"
