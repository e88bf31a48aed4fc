"""Stored jobs in the language of pulse codes, streamed. Their blocks of CREDIT are answered, and the end."""

from passo.options.jobs.errors import NOTICE_JOB_ENDED
from passo.options.jobs.language_grbl import end_text, teach_lines
from passo.protocols.pulses.protocol import ACK, CREDIT, WINDOW
from passo.protocols.words import Words

LIMITS = (WINDOW - CREDIT, CREDIT)  # codes not yet answered, from which on no more are given; bytes given at once
FRAME = (b"{stream}\n", b"{end}")  # the bytes before a job, and after it


def count_units(data):
    """Return the number of codes in `data`; the end of the file counts as one."""
    if data == FRAME[0]:
        return 0
    return 1 if data == FRAME[1] else len(data)


def count_answers(said, before, given):
    """Return the codes answered: `before` and CREDIT for each ACK in the bytes `said`; `given`, all codes, once the program has been played to its
    end."""
    return given if b"end\n" in said else before + CREDIT * said.count(ACK)


def extend(protocol, board):
    """Add the `$F` lines, the notice, and the counting of answers to a link's protocol."""
    protocol.stored = LIMITS, FRAME, count_units, count_answers
    words = Words.words_of(protocol)
    words.notices[NOTICE_JOB_ENDED] = end_text
    teach_lines(words)
