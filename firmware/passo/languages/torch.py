"""The torch manipulator's frames on a link."""

from passo.languages.axes import independent
from passo.protocols.torch import Torch


def opened(link, board, controller, shared):
    independent(link, board, controller, shared)
    if "changeover" not in shared:
        from passo.control.changeover import Changeover

        shared["changeover"] = Changeover(board, controller)
    axes = board["axes"][:2]
    steps = [axis["jog_steps"] or board["jog"]["steps"] for axis in axes]
    speeds = [axis["jog_steps_s"] or board["speed"]["default"] for axis in axes]
    return Torch(steps, speeds, link["idle_gap_ms"], link["tell_end"])
