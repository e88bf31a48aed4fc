"""What grbl's language says of stored jobs: lines, each answered by `ok` or `error`."""

LIMITS = (8, 126)  # lines not yet answered, from which on no more are given; bytes given at once
FRAME = (b"", b"")  # what stands before a job, and behind it


def units(data):
    return bytes(data).count(b"\n")


def answers(said, before, given):
    return before + said.count(b"ok\r\n") + said.count(b"error:")
