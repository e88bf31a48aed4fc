"""Pulse files on a link; its links share one step program."""

from passo.protocols import extend_language
from passo.protocols.pulses.protocol import Pulses
from passo.protocols.pulses.report import port_byte  # noqa: F401: for its page
from passo.protocols.setting_lines import teach_lines
from passo.protocols.words import Words

NEEDS = ("pauses",)
WANTS = "step_program"  # the option whose key the board file has to have
_LEAST_STEPS_M = 100  # as the manifest of step_program has it


def check(board):
    """Return None, or the reason why the board cannot speak pulses."""
    return None if board.get(WANTS) else "pulses wants the section %s" % WANTS


def settings(board, table):
    """A step program wants more steps/mm than other machines do; its own settings are the option's."""
    for number in range(len(board["axes"])):
        name, places, default, _, most = table[100 + number]
        table[100 + number] = name, places, default, _LEAST_STEPS_M, most


def create(link, number, board, controller, shared, most):
    """Return the Pulses of a link."""
    pulses = Pulses("".join([axis["name"] for axis in board["axes"]]), board[WANTS])
    teach_lines(Words.words_of(pulses))
    return extend_language(pulses, board, "pulses")
