"""The jobs of a browser's tab: kept in memory, gone with the tab.

    jobs = Jobs({"part.gcode": "G0 X1\n"}, "grbl")
    jobs.lines_of("part.gcode")        # [(number, bytes)] as they are sent, or the number of an error

The page asks for the same methods of `passo panel`'s folder of jobs.
"""

from host_tools.clients.grbl_wire import number_line
from host_tools.programs.program_lines import WrongLetter, program_lines, raw_lines_of
from passo import errors

_MOST_BYTES = 8_000_000
_PIECE = 32_768
_MOST_NAME = 60
_LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789"


def text_error(text):
    """Return 0 if a file may be a job, else NOT_A_JOB: it is empty, or has zero bytes, as pictures have."""
    return errors.NOT_A_JOB if "\0" in text or not text.strip() else 0


class Jobs:
    def __init__(self, jobs, language):
        """`jobs`: {name: text}; `language`: grbl's lines are numbered."""
        self._jobs = dict(jobs)
        self._coming = ("", "")  # name and text of a job that comes in pieces
        self._grbl = language == "grbl"

    def job_names(self):
        return [(name, len(self._jobs[name])) for name in sorted(self._jobs)]

    def name_error(self, name):
        """Return 0 if a job may have this name, else JOB_NAME."""
        good = 0 < len(name) <= _MOST_NAME and name[0] in _LETTERS and name[-1] not in ". "
        return 0 if good and not [letter for letter in name if letter not in _LETTERS + " ._-"] else errors.JOB_NAME

    def lines_of(self, name):
        """Return [(number, bytes)] as they are sent, or the number of an error."""
        if name not in self._jobs:
            return errors.NO_SUCH_JOB
        text = self._jobs[name]
        if not self._grbl:
            found = [(number + 1, line.partition("#")[0].strip()) for number, line in enumerate(text.split("\n"))]
            return [(number, line.encode()) for number, line in found if line]
        try:
            return [(number, number_line(number, line)) for number, line in program_lines(raw_lines_of(text.encode()))]
        except WrongLetter as wrong:
            return {"error": errors.JOB_LINE, "line": wrong.number, "text": ""}

    def facts_of(self, name, settings):
        """Return {}: a tab does not analyse jobs; or NO_SUCH_JOB."""
        return {} if name in self._jobs else errors.NO_SUCH_JOB

    def text_piece(self, name, at):
        """Return (text from character `at` on, at most 32 kB, and how many there are), or the number of an error."""
        if name not in self._jobs:
            return errors.NO_SUCH_JOB
        return self._jobs[name][at : at + _PIECE], len(self._jobs[name])

    def add_piece(self, name, at, piece, last):
        """Add a piece that begins at character `at`; return 0 or the number of an error."""
        if at == 0:
            self._coming = (name, "")
        if self._coming[0] != name or len(self._coming[1]) != at:
            return errors.JOB_PIECE
        text = self._coming[1] + piece
        if len(text) > _MOST_BYTES:
            return errors.JOB_SIZE
        self._coming = (name, text)
        return self.put_job(name, text) if last else 0

    def put_job(self, name, text):
        """Store a job; returns 0 or the number of an error (its name, its size, its text)."""
        error = self.name_error(name)
        if error:
            return error
        if len(text) + sum([len(self._jobs[other]) for other in self._jobs if other != name]) > _MOST_BYTES:
            return errors.JOB_SIZE
        error = text_error(text)
        if not error:
            self._jobs[name] = text
        return error

    def remove_job(self, name):
        """Delete a job; returns 0, or NO_SUCH_JOB."""
        if name not in self._jobs:
            return errors.NO_SUCH_JOB
        del self._jobs[name]
        return 0
