"""Outputs of a raw board file, whatever else may be wrong with it: they go safe before anything else is loaded.

    safe(outputs(BOARD))
"""

from machine import Pin


def entries(board, key):
    """Return the list that stands under `key` of a raw board file, an empty one if something else does."""
    found = board.get(key) if isinstance(board, dict) else ()
    return list(found) if isinstance(found, (list, tuple)) else []


def outputs(board):
    """Whatever it says that it drives."""
    found = entries(board, "outputs")
    if isinstance(board, dict):
        found += [board.get("tool"), board.get("spindle")]
    return found


def safe(outputs):
    """All of them inactive and the tool off: drivers disabled."""
    for entry in outputs:
        try:
            Pin(entry["pin"], Pin.OUT, value=1 - entry.get("active", 1))
        except (TypeError, KeyError, ValueError, AttributeError):
            continue  # the board file's check will say what is wrong
