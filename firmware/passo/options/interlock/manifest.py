"""The key `interlock`: motion and outputs that inputs forbid. Only loaded if the board file has it."""

from passo.config.board_error import BoardError

HEAP_KB = 13  # of a Pico with stock MicroPython
RULES = {
    "interlock": {
        "rows": (dict, {}, 0, 40),
        "signals": (dict, {}, 0, 40),
        "elsewhere": (str, "", 0, 400),
        "limits": (dict, {}, 0, 8),
        "release_ms": (int, 20, 1, 1000),  # a changed input's permission counts after this time
        "unasked_ms": (int, 0, 0, 60_000),  # the time at rest before outputs go on that rows switch on by themselves; 0: never
    },
}


def check(board):
    """Compile the rows into masks; add feature, limits and port's part. Raises BoardError."""
    section = board["interlock"]
    for key in ("rows", "signals", "limits"):
        if [name for name in section[key] if not isinstance(section[key][name], str)]:
            raise BoardError("interlock.%s: names are wanted, in an interlock with texts behind them" % key)
    additions = board["additions"]
    if additions.masks is None:
        from passo.options.interlock.manifest_table import compile_rows

        additions.masks = compile_rows(board)
    for key in ("rows", "signals", "elsewhere"):
        del section[key]
    additions.limits = section["limits"]
    additions.features["interlock"] = "passo.options.interlock.control", "InterlockWatch"
    additions.parts["veto"] = "passo.options.interlock.port_pins"
