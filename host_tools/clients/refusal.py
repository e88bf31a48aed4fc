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
    """The number and the meaning of an answer `error:N`, in one sentence; other answers as they are. `line`: the refused line, bytes."""
    number = re.sub(r"\D", "", answer)
    return _("error {}, {}", number, error_meaning(int(number), line)) if number else answer


def lines_before_ok(line, text):
    """Return the lines of the answer `text` before its ok. `line`: the line it answers. Raises Refused if it ends with error:N."""
    *told, last = text.splitlines()
    if last != "ok":
        raise Refused("{}: {}", line, explain_error(last), number=int(last[6:]))
    return told


def error_meaning(error, line):
    """The meaning of an error, for the line (bytes) that it refuses."""
    return error_cause(error, line) or error_text(error)


def error_cause(error, line):
    """The cause of an error in a sentence, if the line (bytes) shows it: a checksum, or too many characters; else ""."""
    if error == errors.LETTER and _CHECKSUM.search(line):
        return _("checksums such as {} are for 3D printers: switch them off in the program that made the file", _CHECKSUM.search(line)[0].decode())
    text = bare_line(line)
    if error == errors.LINE_TOO_LONG and len(text) > longest_line(text):
        return _("the line has {} characters, and the board takes {}: shorten it", len(text), longest_line(text))
    return ""
