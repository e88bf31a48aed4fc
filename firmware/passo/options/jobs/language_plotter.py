"""Stored jobs in the plotter's language: packets, each answered by a byte. One at a time: a refused one has no answer, and nothing
behind it may be done."""

from passo.options.jobs.language_grbl import teach_lines
from passo.protocols.plotter.words import PacketWords

LIMITS = (1, 6)  # packets not yet answered; bytes given at once
FRAME = (b"", b"")  # the bytes before a job, and after it


def count_units(data):
    """Return 1: the bytes given at once are a packet."""
    return 1


def count_answers(said, before, given):
    """Return `before`, the packets answered so far, plus those that the bytes `said` answer; `given`: packets given."""
    return before + len(said)


def extend(protocol, board):
    """Add the `$F` lines, and the counting of answers to a link's protocol."""
    protocol.stored = LIMITS, FRAME, count_units, count_answers
    teach_lines(PacketWords.words_of(protocol))
