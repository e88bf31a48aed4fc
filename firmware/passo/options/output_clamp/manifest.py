"""An output named `clamp`, or p0_clamp … p9_clamp: what holds the work, and lets it go only on M11."""

RULES = {
    "features": (dict, {}, 0, 16),  # set by check(): (module, class) by the name of a feature, see machine_builder.rows()
}


def check(board):
    board["features"]["clamp"] = "passo.options.output_clamp.control", "Clamp"
