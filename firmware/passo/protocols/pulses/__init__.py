"""Pulse files on a link; its links share one step program."""

from passo.protocols import extended
from passo.protocols.pulses.protocol import Pulses
from passo.protocols.pulses.report import port_byte  # noqa: F401: for its page
from passo.protocols.setting_lines import teach
from passo.protocols.words import Words

NEEDS = ("pauses",)
_LEAST_STEPS_M = 100  # as the manifest of step_program has it


def check(board):
    return None if board.get("step_program") else "pulses wants the section step_program"


def settings(board, table):
    """Add to the settings: the drivers' interval, and the speed of moves by hand and of programs that say none."""
    for number in range(len(board["axes"])):
        name, places, default, _, most = table[100 + number]
        table[100 + number] = name, places, default, _LEAST_STEPS_M, most
    config = board["step_program"]
    table[181] = ("interval_us", 0, config["interval_us"], 1, 250_000)
    table[182] = ("program_speed", 0, config["default_mm_min"], 1, 900_000)


def create(link, number, board, controller, shared, most):
    pulses = Pulses("".join([axis["name"] for axis in board["axes"]]), board["step_program"])
    teach(Words.of(pulses))
    return extended(pulses, board, "pulses")
