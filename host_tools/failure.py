"""The error for users: one line that says what was wrong, where, and what would be right."""


class Failure(Exception):
    """Ends a verb of `passo` with its text on stderr and exit status 1."""
