"""Stored jobs in grbl's language: lines, each answered by `ok` or `error`."""

from passo.options.jobs import language

LIMITS = (8, 126)  # lines not yet answered, from which on no more are given; bytes given at once
FRAME = (b"", b"")  # what stands before a job, and behind it


def units(data):
    return bytes(data).count(b"\n")


def answers(said, before, given):
    return before + said.count(b"ok\r\n") + said.count(b"error:")


def extend(protocol, board):
    protocol.stored = LIMITS, FRAME, units, answers
    protocol.learn(language)
