"""The plotter's language on a link."""

from passo.batch import Points
from passo.protocols import extend_language
from passo.protocols.plotter.protocol import Plotter
from passo.protocols.plotter.words import PacketWords
from passo.protocols.setting_lines import add_jogs, teach_lines

NEEDS = ("drawing",)


def settings(board, table):
    """Add to the settings: one jog of each axis in mm, and the speed at the start in the board file's unit."""
    add_jogs(board["axes"], board, table)
    speed = board["speed"]
    table[180] = "drawing_speed", 0, speed["default"], speed["min"], speed["max"]


def create(link, number, board, controller, shared, most):
    """Return the Plotter of a link."""
    sign = 1 if board["jog"]["up"][1] == "+" else -1
    jog_up = (0, sign) if board["jog"]["up"][0] == "y" else (sign, 0)
    plotter = Plotter(link["idle_gap_ms"], jog_up, Points(number))
    teach_lines(PacketWords.words_of(plotter))
    return extend_language(plotter, board, "plotter")
