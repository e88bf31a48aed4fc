"""How a client tells that the controller refused something."""

import re

from host_tools.failure import Failure
from host_tools.language import _, error_text
from passo import errors
from passo.protocols.gcode.words import bare_line, longest_line

_CHECKSUM = re.compile(rb"\*\d+\s*$")


class Refused(Failure):
    """The controller refused a line, or raised an alarm; `number` is the file's line, or the error's number, or None."""

    def __init__(self, text, *values, number=None):
        super().__init__(text, *values)
        self.number = number


def explain_error(answer, line=b""):
    """An `error:N` with its meaning, and its cause if the line shows it."""
    number = re.sub(r"\D", "", answer)
    return _("error {}, {}", number, error_meaning(int(number), line)) if number else answer


def lines_before_ok(line, text):
    """The lines before the ok of an answer. Raises Refused."""
    *told, last = text.splitlines()
    if last != "ok":
        raise Refused("{}: {}", line, explain_error(last), number=int(last[6:]))
    return told


def error_meaning(error, line):
    """The meaning of an error, for the line (bytes) that it refuses."""
    return error_cause(error, line) or error_text(error)


def error_cause(error, line):
    """What in the line (bytes) makes the error, if the line shows it; else ""."""
    if error == errors.LETTER and _CHECKSUM.search(line):
        return _("checksums such as {} are for 3D printers: switch them off in the program that made the file", _CHECKSUM.search(line)[0].decode())
    text = bare_line(line)
    if error == errors.LINE_TOO_LONG and len(text) > longest_line(text):
        return _("the line has {} characters, and the board takes {}: shorten it", len(text), longest_line(text))
    return ""
