"""The plotter's language on a link."""

from passo.batch import Points
from passo.protocols.plotter.protocol import Plotter

NEEDS = ("drawing",)


def check(board):
    if board["jobs"] or board["journal"]:
        from passo.protocols.plotter import words  # noqa: F401
    if board["jobs"]:
        from passo.protocols.plotter.stored import answers  # noqa: F401


def create(link, number, board, controller, shared, most):
    sign = 1 if board["jog"]["up"][1] == "+" else -1
    jog_up = (0, sign) if board["jog"]["up"][0] == "y" else (sign, 0)
    made = Plotter(link["idle_gap_ms"], jog_up, Points(number))
    if board["jobs"] or board["journal"]:
        from passo.protocols.plotter.words import PacketWords

        made.words = PacketWords(board)
    return made
