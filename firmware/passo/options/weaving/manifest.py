"""The key `weaving`: seams made of lines and arcs."""

HEAP_KB = 24  # of a Pico with stock MicroPython
RULES = {
    "weaving": {"steady_mm_min": (int, 0, 0, 900_000)},  # up to so fast the path has no ramps, as with $140
}


def check(board):
    """Add the feature, and `$WEAVE=` to grbl."""
    board["additions"].features["program"] = "passo.options.weaving.control", "Weaving"
    if "grbl" in [link["protocol"] for link in board["links"]]:
        board["additions"].languages.append("passo.options.weaving.language_grbl")
