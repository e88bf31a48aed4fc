"""The keys of the two-motor kit on a link."""

from passo.languages.axes import check_axes as check  # noqa: F401
from passo.protocols.keys import Keys

NEEDS = ("independent",)


def create(link, number, board, controller, shared, most):
    return Keys(controller.features["independent"].turning, len(board["axes"]))
