"""Pulse files on a link; its links share one track."""

from passo.control.board_error import BoardError
from passo.protocols.pulses import Pulses


def opened(link, board, controller, shared):
    if not board["track"]:
        raise BoardError("link %s: pulses wants the section track" % link["name"])
    if "track" not in shared:
        from passo.control.track import TrackPlayer

        shared["track"] = TrackPlayer(board, controller)
    return Pulses("".join([axis["name"] for axis in board["axes"]]), board["track"])
