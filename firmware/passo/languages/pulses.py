"""Pulse files on a link; its links share one step program."""

from passo.control.board_error import BoardError
from passo.protocols.pulses import Pulses

NEEDS = ("step_program", "pauses")


def check(link, board):
    if not board["step_program"]:
        raise BoardError("link %s: pulses wants the section step_program" % link["name"])


def create(link, number, board, controller, shared, most):
    return Pulses("".join([axis["name"] for axis in board["axes"]]), board["step_program"])
