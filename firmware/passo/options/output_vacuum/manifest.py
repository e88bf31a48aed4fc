"""An output named `vacuum`, or p0_vacuum … p9_vacuum: a vacuum cleaner that G-code switches."""

RULES = {
    "features": (dict, {}, 0, 16),  # set by check(): (module, class) by the name of a feature, see machine_builder.rows()
}


def check(board):
    board["features"]["vacuum"] = "passo.options.output_vacuum.control", "Vacuum"
