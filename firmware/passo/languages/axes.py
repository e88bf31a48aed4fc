"""What languages whose axes run on their own have in common."""

from passo.control.board_error import BoardError


def check_axes(link, board):
    """Raises BoardError if the machine has fewer than two axes."""
    if len(board["axes"]) < 2:
        raise BoardError("link %s: %s wants two axes" % (link["name"], link["protocol"]))
