"""The torch manipulator's language on a link: frames, or its HTTP table if the link's port is "http"."""

from passo.protocols.torch.protocol import Torch

NEEDS = ("changeover",)
OPTIONS = {"independent": ("passo.options.independent.control", "Independent")}


def check(board):
    return None if len(board["axes"]) > 1 else "torch wants two axes"


def create(link, number, board, controller, shared, most):
    axes = board["axes"][:2]
    steps = [axis["jog_steps"] or board["jog"]["steps"] for axis in axes]
    speeds = [axis["jog_steps_s"] or board["speed"]["default"] for axis in axes]
    if link["port"] == "http":
        from passo.protocols.torch.forms import Forms  # here: few boards have a radio

        return Forms(controller.machine, [axis["steps_per_m"] for axis in axes], steps, speeds)
    return Torch(steps, speeds, link["idle_gap_ms"], link["tell_end"])
