"""`player` "timer": on rp2 chips an interrupt for each word sets the pins, in any order."""

RULES = {}


def extend(rules):
    """Let `player` be "timer"."""
    rules["player"] += ("timer",)


def check(board):
    """Have the port make this player."""
    if board["chip"][:2] == "rp":
        board["additions"].player_module = "passo.options.player_timer.port_rp2"
