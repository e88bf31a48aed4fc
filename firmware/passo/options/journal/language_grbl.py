"""The journal in grbl's language."""

from passo.options.journal import language


def extend(protocol, board):
    protocol.learn(language)
