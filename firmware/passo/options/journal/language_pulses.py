"""The journal in the language of pulse codes."""

from passo.options.journal import language
from passo.protocols.words import Words


def extend(protocol, board):
    Words.of(protocol).learn(language)
