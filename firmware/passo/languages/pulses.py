"""Pulse files on a link; its links share one track."""

from passo.control.board_error import BoardError
from passo.protocols.pulses import Pulses

NEEDS = ("track", "pauses")


def check(link, board):
    if not board["track"]:
        raise BoardError("link %s: pulses wants the section track" % link["name"])


def create(link, number, board, controller, shared, most):
    return Pulses("".join([axis["name"] for axis in board["axes"]]), board["track"])
