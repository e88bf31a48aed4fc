"""The torch manipulator's language on a link: frames, or its HTTP table if the link's port is "http"."""

from passo.protocols import extend_language
from passo.protocols.setting_lines import add_jogs
from passo.protocols.torch.protocol import Torch

NEEDS = ("changeover",)
OPTIONS = {"independent": ("passo.options.independent.control", "Independent")}


def check(board):
    """Return None, or the reason why the board cannot speak torch."""
    return None if len(board["axes"]) > 1 else "torch wants two axes"


def settings(board, table):
    """Add to the settings: one jog of each axis in mm, and its speed in mm/min."""
    axes = board["axes"][:2]
    add_jogs(axes, board, table)
    for number, axis in enumerate(axes):
        steps_per_m = axis["steps_per_m"]
        speed = ((axis["jog_steps_s"] or board["speed"]["default"]) * 60_000_000 + steps_per_m // 2) // steps_per_m
        table[170 + number] = axis["name"] + "_jog_speed", 3, speed, 1, 999_999_999


def create(link, number, board, controller, shared, most):
    """Return the Torch of a link, or the Forms of one on http."""
    if link["port"] == "http":
        from passo.protocols.torch.forms import Forms  # here: few boards have a radio

        return Forms(controller.machine)
    return extend_language(Torch(controller.machine.settings, link["idle_gap_ms"], link["tell_end"]), board, "torch")
