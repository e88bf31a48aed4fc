"""The keys of the two-motor kit on a link."""

from passo.languages.axes import independent
from passo.protocols.keys import Keys


def opened(link, board, controller, shared):
    return Keys(independent(link, board, controller, shared), len(board["axes"]))
