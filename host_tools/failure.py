"""The error that a user is meant to read: one line saying what was wrong, where, and what would be right."""


class Failure(Exception):
    """Ends a verb of `passo` with its text on stderr and exit status 1."""
