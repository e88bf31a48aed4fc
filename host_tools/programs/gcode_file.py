"""G-code files on the PC: the lines that a controller should get, with their numbers in the file, as program_lines.py reads them."""

from host_tools.failure import Failure, reason
from host_tools.language import _, error_text
from host_tools.programs.file_kinds import FIRST, refuse_others
from host_tools.programs.program_lines import WrongLetter, job_error, name_letter, program_lines


def read(path, ended=None, job=False):
    """Return [(number, bytes)] of the lines to send, without comments, blanks, N words and the program's number. `ended`: see program_lines().
    `job`: refuse lines that no job may have. Raises Failure."""
    return list((jobs_only if job else iter)(file_lines(path, ended)))


def file_lines(path, ended=None):
    """Yield (number, bytes) of the lines to send, for files that are too long to keep. `ended`: see program_lines(). Raises Failure at the first
    wrong line."""
    try:
        with open(path, "rb") as file:
            first = file.read(FIRST)
            refuse_others(path, first)
            if b"\0" in first:
                raise _no_text(path)
            file.seek(0)
            yield from lines_of(path, _raw_rows(file, path), ended)
    except OSError as error:
        raise Failure("cannot read {}: {}", path, reason(error)) from error


def lines_of(name, rows, ended=None):
    """Yield (number, bytes) of the lines to send, of raw lines. `ended`: see program_lines(). Raises Failure, which names the file `name`."""
    empty = True
    try:
        for row in program_lines(rows, ended):
            empty = False
            yield row
    except WrongLetter as wrong:
        raise wrong_letter(name, wrong) from None
    if empty:
        raise Failure("{} has no line of G-code", name)


def wrong_letter(name, wrong):
    """Return the Failure that explains a WrongLetter."""
    shown = f"“{wrong.letter}” " if wrong.letter.isprintable() else ""
    return Failure("{}: line {}: {}({}) is no letter of G-code: only a comment may have it", name, wrong.number, shown, name_letter(wrong.letter))


def jobs_only(rows):
    """Yield the rows. Raises Failure at the first row that no job may have."""
    for number, line in rows:
        error = job_error(line)
        if error:
            raise Failure("line {}, {}: {}", number, line.decode("ascii", "backslashreplace"), _("error {}, {}", error, error_text(error)))
        yield number, line


def _raw_rows(file, path):
    """Yield the lines of a binary file, without their ends. Raises Failure at a zero byte."""
    for raw in file:
        if b"\0" in raw:
            raise _no_text(path)
        yield from raw.splitlines()


def refuse_others_at(path, taken=()):
    """Raise Failure if a file is of a kind that another verb takes, and not of those `taken`."""
    with open(path, "rb") as file:
        refuse_others(path, file.read(FIRST), taken)


def _no_text(path):
    return Failure("{} is no text: there are zero bytes in it", path)


def last_number(path):
    """Return the number of lines in a file, of all kinds. Raises Failure if it cannot be read."""
    try:
        with open(path, "rb") as file:
            return sum(len(raw.splitlines()) for raw in file)
    except OSError as error:
        raise Failure("cannot read {}: {}", path, reason(error)) from error


def clock_text(seconds):
    """Return seconds as h:mm:ss, or m:ss below an hour."""
    minutes, seconds = divmod(int(round(seconds)), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{seconds:02}" if hours else f"{minutes}:{seconds:02}"
