"""The keys of the two-motor kit on a link."""

from passo.protocols.keys.protocol import Keys

NEEDS = ()
OPTIONS = {"independent": ("passo.options.independent.control", "Independent")}


def check(board):
    """Return None, or the reason why the board cannot speak keys."""
    return None if len(board["axes"]) > 1 else "keys wants two axes"


def create(link, number, board, controller, shared, most):
    """Return the Keys of a link."""
    return Keys(controller.features["independent"].is_turning, len(board["axes"]))
