"""The key `weaving`: seams made of lines and arcs."""

HEAP_KB = 24  # of a Pico with stock MicroPython
RULES = {
    "weaving": {"steady_mm_min": (int, 0, 0, 900_000)},  # up to so fast the path has no ramps, as with $140
}


def check(board):
    """Add the feature, `$WEAVE=` to grbl, and seams to the torch's frames and to its page."""
    board["additions"].features["program"] = "passo.options.weaving.control", "Weaving"
    spoken = [link["protocol"] for link in board["links"]]
    pages = ["page" for link in board["links"] if link["port"] == "page" and link["protocol"] == "torch"]
    board["additions"].add_languages("passo.options.weaving.language_", [language for language in ("grbl", "torch") if language in spoken] + pages[:1])
