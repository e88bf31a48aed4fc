"""The journal in the language of pulse codes."""

from passo.options.journal.language_grbl import teach_lines
from passo.protocols.words import Words


def extend(protocol, board):
    """Add the `$JR` lines to a link's protocol."""
    teach_lines(Words.words_of(protocol))
