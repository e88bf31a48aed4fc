"""How a client tells that the controller refused something."""

import re

from host_tools.failure import Failure


class Refused(Failure):
    """The controller refused a line, or raised an alarm; `number` is the file's line, or the error's number, or None."""

    def __init__(self, text, number=None):
        super().__init__(text)
        self.number = number


def explain(answer):
    """An `error:N` with its meaning."""
    from host_tools.language import error_text

    number = re.sub(r"\D", "", answer)
    return f"error {number}, {error_text(int(number))}" if number else answer
