"""A board file with the steps/mm and travel that its running board has set.

    board = as_set(board, {100: "49.218", 130: "200.000"})
    board, told = as_running(board, "plotter", "/dev/ttyUSB0", 57600)   # asks the board; `told`: a line for people
    board, told = with_client_settings(board, client)                   # the same of one that is connected

Every command of the PC that turns mm into steps asks here, so that all count alike.
"""

from passo.config.setting_numbers import LASER, MAX_RPM, STEPS, TRAVEL

from host_tools.failure import Failure
from host_tools.language import _


def as_set(board, settings):
    """Return the board file with steps/mm, travel and the spindle's laser and highest speed from a machine's settings, {number: value}. Axes without
    steps/mm in the settings are left out; without any settings all stay."""
    axes, spindle = [], dict(board.get("spindle") or {})
    for number, axis in enumerate(board["axes"]):
        per_mm, travel_mm = (float(settings.get(first + number, 0)) for first in (STEPS, TRAVEL))
        if per_mm and travel_mm:
            axis = {**axis, "steps_per_m": round(1000 * per_mm), "travel_steps": round(per_mm * travel_mm)}
        if not settings or STEPS + number in settings:
            axes.append(axis)
    if spindle and LASER in settings:
        spindle.update(laser=float(settings[LASER]) > 0, max_rpm=float(settings.get(MAX_RPM, spindle["max_rpm"])))
    return {**board, "axes": axes, **({"spindle": spindle} if spindle else {})}


def as_running(board, language, port, baud=None):
    """Return (the board file as the board at `port` has it, a line that says whose steps/mm count). A board that does not tell its settings, such as
    a document's own, or a computer without a port, `port` None, has the file's."""
    if port is None:
        return board, _("steps/mm {}: the board file's", _scale_text(board))
    from host_tools.clients import settings

    try:
        with settings.open_settings(language, port, baud) as asked:
            found = _ask_settings(asked, board)
    except (Failure, IndexError, ValueError):
        found = None
    return _compare_scales(board, found)


def with_client_settings(board, client):
    """Return as_running() of a board that a client of any language but grbl is connected to."""
    from host_tools.clients.settings import Asked

    try:
        found = _ask_settings(Asked(client), board)
    except (Failure, IndexError, ValueError):
        found = None
    return _compare_scales(board, found)


def _ask_settings(asked, board):
    """Return {number: value} of the board's steps/mm and travel. Raises Failure."""
    return {first + axis: asked.get(first + axis) for axis in range(len(board["axes"])) for first in (STEPS, TRAVEL)}


def _compare_scales(board, found):
    """Return (the board file with the settings `found`, None: none; a line that says whose steps/mm count)."""
    if found is None:
        return board, _("steps/mm {}: the board file's, for the board tells no settings", _scale_text(board))
    here = as_set(board, found)
    if _scales_of(here) == _scales_of(board):
        return here, _("steps/mm {}: the board's, as in the board file", _scale_text(here))
    return here, _("steps/mm {}: the board's own; the board file says {}", _scale_text(here), _scale_text(board))


def _scales_of(board):
    """Return the steps a metre of each axis."""
    return [axis["steps_per_m"] for axis in board["axes"]]


def _scale_text(board):
    """Return the steps/mm of each axis, for people."""
    return ", ".join(f"{axis['name'].upper()} {axis['steps_per_m'] / 1000:.3f}" for axis in board["axes"])
