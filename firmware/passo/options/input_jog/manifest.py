"""Inputs named `jog_x+`, `jog_x-` … `jog_fast`: a jog pendant, buttons or a stick."""

from passo.config.board_error import BoardError

RULES = {}


def check(board):
    """Check the names of the pendant's inputs; add the feature. Raises BoardError."""
    known = ["jog_" + axis["name"] + sign for axis in board["axes"] for sign in "+-"] + ["jog_fast"]
    if "grbl" not in [link["protocol"] for link in board["links"]]:
        raise BoardError("a pendant (inputs jog_…) wants a link that speaks grbl")
    for item in board["inputs"]:
        if item["name"][:4] == "jog_" and item["name"] not in known:
            raise BoardError("input %s: a pendant's are %s" % (item["name"], ", ".join(known)))
    board["additions"].features["pendant"] = "passo.options.input_jog.control", "Pendant"
