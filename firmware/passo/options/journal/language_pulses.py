"""The journal in the language of pulse codes."""

from passo.options.journal.language_grbl import teach
from passo.protocols.words import Words


def extend(protocol, board):
    teach(Words.of(protocol))
