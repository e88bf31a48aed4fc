"""The journal in the plotter's language."""

from passo.options.journal.language_grbl import teach_lines
from passo.protocols.plotter.words import PacketWords


def extend(protocol, board):
    """Add the `$JR` lines to a link's protocol."""
    teach_lines(PacketWords.words_of(protocol))
