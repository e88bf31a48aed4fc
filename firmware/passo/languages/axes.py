"""What languages whose axes run on their own have in common."""

from passo.control.board_error import BoardError
from passo.control.independent import Independent


def independent(link, board, controller, shared):
    """The part of the machine that runs axes on their own; the first language that wants it brings it."""
    if len(board["axes"]) < 2:
        raise BoardError("link %s: %s wants two axes" % (link["name"], link["protocol"]))
    if "independent" not in shared:
        shared["independent"] = Independent(board, controller)
    return shared["independent"]
