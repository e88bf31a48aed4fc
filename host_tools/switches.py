"""Outputs of a board file that nothing switches: no command of its languages, no feature of the firmware.

    for text in caution_lines(board): …          # a line each, with the names that it may have

A plain fault of a board file that is in use: `passo` warns of it, and the board is built and starts as before.
"""

import sys

from passo.config.board_error import names_of

from host_tools.language import _

_OF_GCODE = {"flood", "mist", "reverse", "clamp"}
_NUMBERED = {f"p{number}" for number in range(10)}


def outputs_without_switch(board):
    """Return the names of the outputs that nothing switches."""
    gcode = any(link["protocol"] == "grbl" for link in board["links"])
    clamped = "clamp" in names_of(board.get("outputs"), 2)
    return [item["name"] for item in board.get("outputs", ()) if not _is_switched(item, gcode, clamped)]


def _is_switched(item, gcode, clamped):
    """True if a language or a feature of the firmware switches an output. `gcode`: a link speaks grbl; `clamped`: the board has a clamp, which M10
    and M11 are for."""
    name = item["name"]
    if name[:6] == "enable" or item.get("role", "none") != "none":
        return True
    number, _sep, what = name.rpartition("_")
    if number:
        return gcode and number in _NUMBERED and what in ("vacuum", "clamp")
    return gcode and (name in _OF_GCODE | _NUMBERED or name == "vacuum" and not clamped)


def caution_lines(board):
    """Return a sentence for each output that nothing switches."""
    free = outputs_without_switch(board)
    return [_caution_text(board, name) for name in free]


def print_cautions(board):
    """Print the cautions on stderr, beside the output of a command for programs."""
    for text in caution_lines(board):
        print(text, file=sys.stderr)


def _caution_text(board, name):
    """Return the sentence about an output, with the names that it may have."""
    if not any(link["protocol"] == "grbl" for link in board["links"]):
        return _("caution: nothing switches the output {}: without a link that speaks grbl an output is called enable, or has a role", name)
    if name == "vacuum":
        return _("caution: nothing switches the output vacuum: M10 and M11 are the clamp's; call it p1_vacuum, and M64 P1 and M65 P1 switch it")
    return _("caution: nothing switches the output {}: names that are switched are enable, flood, mist, reverse, vacuum, clamp and p0 to p9", name)
