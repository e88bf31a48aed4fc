"""Pulse files on a link; its links share one step program."""

from passo.protocols.pulses.protocol import Pulses
from passo.protocols.pulses.report import port_byte  # noqa: F401: for its page

NEEDS = ("pauses",)


def check(board):
    if board["jobs"] or board["journal"]:
        from passo.protocols.jobs import words  # noqa: F401
    if board["jobs"]:
        from passo.protocols.pulses.stored import answers  # noqa: F401
    return None if board.get("step_program") else "pulses wants the section step_program"


def create(link, number, board, controller, shared, most):
    made = Pulses("".join([axis["name"] for axis in board["axes"]]), board["step_program"])
    if board["jobs"] or board["journal"]:
        from passo.protocols.jobs.words import Words

        made.words = Words(board)
    return made
