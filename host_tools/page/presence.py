"""The orders that a page on another computer may give only while somebody is at the machine. A board that serves its own page checks
that by its links (options/network/control.py).

    starts_motion({"do": "output", "name": "spindle_cw"})      # True
"""

_STARTS = ("run", "resume", "play", "weave", "motor")  # the last three: of one language each
_TOOLS = ("spindle_cw", "spindle_ccw", "tool_on")


def starts_motion(order):
    """True if an order (a dict) starts the tool or a program, or goes on with one."""
    name = order.get("do")
    if name == "output":
        return order.get("name") in _TOOLS
    if name == "line":
        return _line_starts(str(order.get("line")).upper().replace(" ", ""))
    if name == "stored":
        return order.get("what") == "run" and not order.get("check")
    if name == "queue":
        return order.get("what") == "run"
    if name == "prove":
        return order.get("what") == "begin" and bool(order.get("pins"))
    if name == "map":
        return order.get("what") == "probe"
    if name == "recover":
        return order.get("what") in ("begin", "down")
    return name in _STARTS and not order.get("check")


def _line_starts(line):
    """True if a typed line does: M3, M4, a stored job, a start line, `~`. An M in a line with a comment counts, too."""
    words = line.split("M")[1:]
    if line[:3] in ("$F=", "$N0", "$N1") or "~" in line or words and "(" in line:
        return True
    for word in words:
        digits = word.lstrip("0")
        if digits[:1] in ("3", "4") and not digits[1:2].isdigit():
            return True
    return False
