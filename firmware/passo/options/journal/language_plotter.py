"""The journal in the plotter's language."""

from passo.options.journal import language
from passo.protocols.plotter.words import PacketWords


def extend(protocol, board):
    PacketWords.of(protocol).learn(language)
