"""The torch manipulator's frames on a link."""

from passo.languages.axes import check_axes as check  # noqa: F401
from passo.protocols.torch import Torch

NEEDS = ("independent", "changeover")


def create(link, number, board, controller, shared, most):
    axes = board["axes"][:2]
    steps = [axis["jog_steps"] or board["jog"]["steps"] for axis in axes]
    speeds = [axis["jog_steps_s"] or board["speed"]["default"] for axis in axes]
    return Torch(steps, speeds, link["idle_gap_ms"], link["tell_end"])
