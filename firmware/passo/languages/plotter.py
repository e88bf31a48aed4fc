"""The plotter's language on a link."""

from passo.protocols.plotter import Plotter


def opened(link, board, controller, shared):
    sign = 1 if board["jog"]["up"][1] == "+" else -1
    return Plotter(link["idle_gap_ms"], (0, sign) if board["jog"]["up"][0] == "y" else (sign, 0))
