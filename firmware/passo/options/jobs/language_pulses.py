"""Stored jobs in the language of pulse codes, streamed. Their blocks of CREDIT are answered, and the end."""

from passo import errors
from passo.options.jobs.language_grbl import ended, teach
from passo.protocols.pulses.protocol import ACK, CREDIT, WINDOW
from passo.protocols.words import Words

LIMITS = (WINDOW - CREDIT, CREDIT)  # codes not yet answered, from which on no more are given; bytes given at once
FRAME = (b"{stream}\n", b"{end}")  # the bytes before a job, and after it


def units(data):
    if data == FRAME[0]:
        return 0
    return 1 if data == FRAME[1] else len(data)


def answers(said, before, given):
    """All is answered when the program has been played to its end."""
    return given if b"end\n" in said else before + CREDIT * said.count(ACK)


def extend(protocol, board):
    protocol.stored = LIMITS, FRAME, units, answers
    words = Words.of(protocol)
    words.notices[errors.NOTICE_JOB_ENDED] = ended
    teach(words)
