"""The plotter's language on a link."""

from passo.batch import Points
from passo.protocols import extended
from passo.protocols.plotter.protocol import Plotter

NEEDS = ("drawing",)


def create(link, number, board, controller, shared, most):
    sign = 1 if board["jog"]["up"][1] == "+" else -1
    jog_up = (0, sign) if board["jog"]["up"][0] == "y" else (sign, 0)
    return extended(Plotter(link["idle_gap_ms"], jog_up, Points(number)), board, "plotter")
