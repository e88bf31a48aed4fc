"""Pulse files on a link; its links share one step program."""

from passo.protocols.pulses.protocol import Pulses

NEEDS = ("step_program", "pauses")


def check(board):
    return None if board["step_program"] else "pulses wants the section step_program"


def create(link, number, board, controller, shared, most):
    return Pulses("".join([axis["name"] for axis in board["axes"]]), board["step_program"])
