"""The key `weaving`: seams made of lines and arcs."""

RULES = {
    "weaving": {"steady_mm_min": (int, 0, 0, 900_000)},  # up to so fast the path has no ramps, as with $140
    "features": (dict, {}, 0, 16),  # set by check(): (module, class) by the name of a feature, see machine_builder.rows()
}


def check(board):
    board["features"]["program"] = "passo.control.program", "Program"
    board["features"]["weaving"] = "passo.options.weaving.control", "Weaving"
