"""The facts of a job that follow from its lines: about how long it takes, its tools, and how often it waits for somebody.

    gcode_facts(lines, settings)            # [(number, bytes)], {number: text} → {"lines", "seconds", "parts", "tools", "pauses", "refused"}
    packets_of(board)(lines, settings)      # the same of a plotter's job

`refused`: [line, error] of the first line that the firmware's parser refuses, or None; machines with a rotary axis are not asked.
`parts`: estimated seconds up to each 32nd of the lines. A job of more than MOST_LINES is not estimated: the next order would wait for it.
"""

import re

from host_tools.programs.estimate import Estimate
from host_tools.programs.gcode_time import Limits, estimate_seconds

MOST_LINES = 30_000
_PARTS = 32
_TOOL = re.compile(rb"T(\d+)")
_CHANGE = re.compile(rb"M0*6(?!\d)")
_PAUSE = re.compile(rb"M0*[01](?!\d)")


def gcode_facts(lines, settings):
    """The facts of a job of G-code, a dict. `lines`: [(number, bytes)]; `settings`: {number: text} of the board."""
    found = {"lines": len(lines), "tools": tools_of(lines), "pauses": sum(1 for _, line in lines if _PAUSE.search(line.upper()))}
    if len(lines) <= MOST_LINES:
        answers = [f"${number}={value}" for number, value in settings.items()]
        found.update(_time_fields(estimate_seconds(lines, Limits.of_settings(answers))), refused=_first_refusal(lines, answers))
    return found


def _first_refusal(lines, answers):
    """(number, error) of the first line that the firmware's parser refuses; None: it refuses none, or cannot be asked."""
    from host_tools.programs.replay import RefusedLine, Replay
    from host_tools.programs.replay_machine import Machine

    if not any(row.startswith("$100=") for row in answers) or any(row.startswith("$103=") for row in answers):
        return None
    try:
        Replay(Machine.of_answers(answers, []), lines).check()
    except RefusedLine as refused:
        return refused.number, refused.error
    return None


def tools_of(lines):
    """The tools that a program changes to, ["T1", …] in order; T stands before M6 or beside it. `lines`: [(number, bytes)]."""
    found, chosen = [], ""
    for _, line in lines:
        line = line.upper()
        named = _TOOL.search(line)
        if named:
            chosen = "T" + named[1].decode()
        if chosen and _CHANGE.search(line) and (not found or found[-1] != chosen):
            found.append(chosen)
    return found


def packets_of(board):
    """Return the function that gives the facts of a plotter's job. `board`: its checked board file."""
    times = Estimate(board)

    def packet_facts(lines, settings):
        """Return the facts of a drawing's lines: their count and, up to MOST_LINES, the seconds they take; no tools, no pauses."""
        found = {"lines": len(lines), "tools": [], "pauses": 0}
        words = [line.split() for _, line in lines]
        if len(lines) <= MOST_LINES:
            points = [(word[0] == b"LINE", int(word[1]), int(word[2])) for word in words if len(word) == 3]
            seconds = iter(times.object_s(points))
            found.update(_time_fields([next(seconds) if len(word) == 3 else 0.0 for word in words]))
        return found

    return packet_facts


def _time_fields(seconds):
    """{"seconds", "parts"} of a list with the seconds of each line."""
    until, parts = 0.0, [0.0]
    for index, taken in enumerate(seconds):
        until += taken
        while len(parts) <= (index + 1) * _PARTS // len(seconds):
            parts.append(round(until, 1))
    return {"seconds": round(until, 1), "parts": parts}
