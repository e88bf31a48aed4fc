"""What a page on another computer may do only while somebody is at the machine. A board that serves its own page knows that by its
links (options/network/control.py).

    starts_motion({"do": "output", "name": "spindle_cw"})      # True
"""

_STARTS = ("run", "resume", "play", "weave", "motor")  # and what only one language has
_TOOLS = ("spindle_cw", "spindle_ccw", "tool_on")


def starts_motion(order):
    """Whether an order starts the tool or a program, or goes on with one."""
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
    """The same of a line as typed: M3, M4, a stored job, a start line, the byte that resumes. An M amid comments may be anything."""
    words = line.split("M")[1:]
    if line[:3] in ("$F=", "$N0", "$N1") or "~" in line or words and "(" in line:
        return True
    for word in words:
        digits = word.lstrip("0")
        if digits[:1] in ("3", "4") and not digits[1:2].isdigit():
            return True
    return False
