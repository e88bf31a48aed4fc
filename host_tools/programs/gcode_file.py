"""G-code files on the PC: the lines that a controller should get, with their numbers in the file."""

import re

from host_tools.failure import Failure, reason

_COMMENT = re.compile(rb"\([^)]*\)?|;.*", re.DOTALL)
_PROGRAM = re.compile(rb"[Oo:]\d+$")  # a program's number, which CAM programs begin with
_DROPPED = bytes(byte for byte in range(256) if not 32 < byte < 127 or byte in b"?!~")


def read(path):
    """[(number, bytes)] of the lines that are not empty, without comments, blanks and the program's number. Raises Failure."""
    return list(lines(path))


def lines(path):
    """The same one by one, for files that are too long to keep. Raises Failure as it comes to what is wrong."""
    empty = True
    try:
        with open(path, "rb") as file:
            number = 0
            for raw in file:
                if b"\0" in raw:
                    raise Failure("{} is no text: there are zero bytes in it", path)
                for line in raw.splitlines():
                    number += 1
                    stripped = strip(line)
                    if stripped and stripped != b"%" and not _PROGRAM.match(stripped):
                        empty = False
                        yield number, stripped
    except OSError as error:
        raise Failure("cannot read {}: {}", path, reason(error)) from error
    if empty:
        raise Failure("{} has no line of G-code", path)


def last_number(path):
    """How many lines a file has, of all kinds. Raises Failure."""
    try:
        with open(path, "rb") as file:
            return sum(len(raw.splitlines()) for raw in file)
    except OSError as error:
        raise Failure("cannot read {}: {}", path, reason(error)) from error


def strip(line):
    """`line` as the controller sees it: without comments, blanks and anything but printable ASCII."""
    if b"(" in line or b";" in line:
        line = _COMMENT.sub(b"", line)
    return line.translate(None, _DROPPED)


def has_numbers(lines):
    """True if a line of [(number, bytes)] has an N word; a packed row of dots, behind =, is none."""
    return any(b"N" in line.partition(b"=")[0].upper() for _, line in lines)


def clock(seconds):
    """Seconds as h:mm:ss, or m:ss below an hour."""
    minutes, seconds = divmod(int(round(seconds)), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{seconds:02}" if hours else f"{minutes}:{seconds:02}"
