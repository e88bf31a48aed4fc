"""Pulse files on a link; its links share one step program."""

from passo.protocols import extended
from passo.protocols.pulses.protocol import Pulses
from passo.protocols.pulses.report import port_byte  # noqa: F401: for its page

NEEDS = ("pauses",)


def check(board):
    return None if board.get("step_program") else "pulses wants the section step_program"


def create(link, number, board, controller, shared, most):
    return extended(Pulses("".join([axis["name"] for axis in board["axes"]]), board["step_program"]), board, "pulses")
