"""The journal in the plotter's language."""

from passo.options.journal.language_grbl import teach
from passo.protocols.plotter.words import PacketWords


def extend(protocol, board):
    teach(PacketWords.of(protocol))
