"""How a client tells that the controller refused something."""

import re

from host_tools.failure import Failure
from host_tools.language import _, error_text


class Refused(Failure):
    """The controller refused a line, or raised an alarm; `number` is the file's line, or the error's number, or None."""

    def __init__(self, text, *values, number=None):
        super().__init__(text, *values)
        self.number = number


def explain(answer):
    """An `error:N` with its meaning."""
    number = re.sub(r"\D", "", answer)
    return _("error {}, {}", number, error_text(int(number))) if number else answer
