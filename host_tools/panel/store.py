"""The jobs of a panel: files of one folder, by names that are looked at before they reach the file system.

    store = Store(Path("jobs"), gcode_lines)
    error = store.add_piece("part.gcode", 0, text, last=True)     # in pieces; the file is there with the last one, whole
    store.lines_of("part.gcode")                               # what gcode_lines makes of it, or the number of an error
"""

import os
import re
from threading import Lock

from host_tools.clients.grbl_wire import number_line
from host_tools.clients.refusal import error_cause
from host_tools.failure import Failure
from host_tools.page.slow_order import is_refusal
from host_tools.panel import job_facts
from host_tools.programs import gcode_file, stored_job
from host_tools.programs.program_makers import advice_of
from host_tools.programs.program_lines import latin_bytes
from host_tools.sim.tab_jobs import text_error
from passo import errors

MOST_BYTES = 64 << 20  # of all jobs
_MOST_JOBS = 500
_MOST_KNOWN = 4 << 20  # bytes of jobs among which the one is looked for that was interrupted
_MOST_STORED = 8 << 20  # bytes of a job for a board's flash, before it is packed
_PIECE = 32_768
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9 ._-]{0,59}")
_RESERVED = re.compile(r"(?i)(con|prn|aux|nul|com\d|lpt\d)(\..*)?")


def gcode_lines(path):
    """[(number, bytes)] as they are sent: without comments, numbered. Raises Failure."""
    return Store.number_lines(gcode_file.read(path, job=True))


def not_a_job(failure):
    """The refusal of a file that is no job, a dict: NOT_A_JOB and the sentence of a Failure."""
    return {"error": errors.NOT_A_JOB, "text": failure.message()}


class Store:
    def __init__(self, folder, read, made=None, facts=None):
        """`read(path)`: a job's lines as a language's driver takes them; raises Failure or OSError if there is no job. `made(name, text)`: name
        and text of the job that a file becomes, or the number of an error; None: a file is a job. A file that has become another is kept
        beside it, for place_job(): `made(name, text, place)`.
        `facts(lines, settings)`: a job's facts, see job_facts.py."""
        self._made = made
        self._facts = facts
        self._folder = folder
        self._read = read
        folder.mkdir(parents=True, exist_ok=True)
        self._coming = {}  # name: pieces so far
        self._programs = {}  # (name, time, bytes): (lines, CRC-32), or None
        self._reading = Lock()  # them: by the panel's loop, or beside it
        self.changed = 0  # counts what has been kept

    def job_names(self):
        """[(name, bytes)] in alphabetical order."""
        found = [path for path in self._folder.iterdir() if path.is_file() and not self.name_error(path.name)]
        return sorted((path.name, path.stat().st_size) for path in found)

    def name_error(self, name):
        """0 if a job may have this name, else JOB_NAME."""
        good = _NAME.fullmatch(name) and not _RESERVED.fullmatch(name) and not name.endswith((".", " "))
        return 0 if good else errors.JOB_NAME

    def _path_of(self, name):
        """The file of a job that exists, or the number of an error."""
        error = self.name_error(name)
        if error:
            return error
        path = self._folder / name
        return path if path.is_file() and not path.is_symlink() else errors.NO_SUCH_JOB

    def lines_of(self, name):
        """The lines of a job as `read` returns them, or a refusal: the number of an error, or a dict."""
        path = self._path_of(name)
        if isinstance(path, int):
            return path
        try:
            return self._read(path)
        except Failure as failure:
            return not_a_job(failure)
        except OSError:
            return errors.NO_SUCH_JOB

    def facts_of(self, name, settings):
        """The facts of a job, a dict (see job_facts.py), or a refusal. `settings`: {number: text} of the board."""
        lines = self.lines_of(name)
        if is_refusal(lines):
            return lines
        found = self._facts(lines, settings) if self._facts else {}
        source = self._source_path(name)
        if found.get("refused"):
            number, error = found["refused"]
            found["advice"] = error_cause(error, dict(lines)[number]) or advice_of(source if source.is_file() else self._path_of(name))
        return {**found, "placed": True} if source.is_file() else found

    def tools_of(self, lines):
        """The tools that a job's lines change to, in order; None: its language has none."""
        return job_facts.tools_of(lines) if self._facts is job_facts.gcode_facts else None

    def programs(self):
        """[(name, lines, CRC-32 as a stored job)] of the jobs by which a board's journal may know one: the newest, up to a bound. Lines
        are gcode_file.read()'s."""
        with self._reading:
            return self._read_programs()

    def _read_programs(self):
        """Read the newest jobs, up to _MOST_KNOWN bytes; see programs(). A file is read again only if it has changed."""
        paths = sorted((path for path in (self._folder / name for name, _ in self.job_names())), key=lambda path: -path.stat().st_mtime_ns)
        found, bytes_ = [], 0
        for path in paths:
            state = path.stat()
            bytes_ += state.st_size
            if bytes_ > _MOST_KNOWN:
                break
            key = path.name, state.st_mtime_ns, state.st_size
            if key not in self._programs:
                try:
                    lines = gcode_file.read(path, job=True)
                    self._programs[key] = lines, stored_job.crc_of(stored_job.gcode_lines(lines))
                except Failure:
                    self._programs[key] = None
            if self._programs[key]:
                found.append((path.name, *self._programs[key]))
        self._programs = {key: value for key, value in self._programs.items() if key[0] in [path.name for path in paths]}
        return found

    def program_lines(self, name):
        """The lines of a job of G-code, as gcode_file.read() has them. Raises Failure."""
        path = self._path_of(name)
        if isinstance(path, int):
            raise Failure("{} has gone", name)
        return gcode_file.read(path, job=True)

    @staticmethod
    def number_lines(lines):
        """[(number, bytes)] of a program's lines with their numbers as N words, as they are sent."""
        return [(number, number_line(number, line)) for number, line in lines]

    def pack_job(self, name):
        """(bytes, CRC-32, the packed bytes) of a job as a board stores it, or the number of an error."""
        path = self._path_of(name)
        if isinstance(path, int):
            return path
        if path.stat().st_size > _MOST_STORED:
            from passo.options.jobs.errors import JOB_SPACE

            return JOB_SPACE
        try:
            data = stored_job.gcode_job(path)
        except Failure as failure:
            return not_a_job(failure)
        return len(data), stored_job.crc_of(data), stored_job.pack_job(data)

    def text_piece(self, name, at):
        """(text from byte `at` on, at most 32 kB, and how many bytes there are), or the number of an error."""
        path = self._path_of(name)
        if isinstance(path, int):
            return path
        with open(path, "rb") as file:
            file.seek(at)
            return file.read(_PIECE).decode("latin-1"), path.stat().st_size

    def add_piece(self, name, at, piece, last):
        """Take a piece of a job's text that begins at character `at`; keep the job behind the `last`. Returns 0 or an error."""
        error = self.name_error(name)
        if error:
            return error
        if at == 0:
            self._coming = {name: ""}  # one at a time: an unfinished upload is forgotten
        before = self._coming.get(name)
        if before is None or len(before) != at:
            return errors.JOB_PIECE
        if last or self._is_full(name, at + len(piece)):
            self._coming.pop(name, None)
            return self.put_job(name, before + piece) if last else errors.JOB_SIZE
        self._coming[name] = before + piece
        return 0

    def put_job(self, name, text):
        """Keep a job under a name, whole or not at all. Returns 0 or a refusal."""
        error = self.name_error(name) or (errors.JOB_SIZE if self._is_full(name, len(text)) else 0) or text_error(text)
        if error:
            return error
        found = self._made(name, text) if self._made else (name, text)
        if is_refusal(found):
            return found
        made, job = found
        error = self._write_file(made, latin_bytes(job))
        source = self._source_path(made)
        source.unlink(missing_ok=True)
        return error or (self._write_file(source.name, text.encode()) if made != name else 0)

    def _write_file(self, name, data):
        """Write a file whole or not at all. Returns 0, or JOB_SIZE if the disk cannot be written."""
        path = self._folder / name
        fresh = self._folder / f".{name}.new"
        try:
            fresh.write_bytes(data)
            os.replace(fresh, path)
            self.changed += 1
        except OSError:
            fresh.unlink(missing_ok=True)
            return errors.JOB_SIZE
        return 0

    def _source_path(self, name):
        """The path of the file from which a job was made; no job has such a name."""
        return self._folder / f".{name}.from"

    def place_job(self, name, place):
        """Make a job anew from its drawing at `place`, (x, y, width) in mm. Returns 0 or a refusal."""
        path = self._path_of(name)
        if isinstance(path, int):
            return path
        try:
            text = self._source_path(name).read_text(encoding="utf-8")
        except OSError:
            return errors.NO_SUCH_JOB
        found = self._made(name.rpartition(".")[0], text, place)
        return found if is_refusal(found) else self._write_file(name, latin_bytes(found[1]))

    def remove_job(self, name):
        """Remove a job and the file it was made from. Returns 0 or an error."""
        path = self._path_of(name)
        if isinstance(path, int):
            return path
        path.unlink()
        self._source_path(name).unlink(missing_ok=True)
        return 0

    def _is_full(self, name, size):
        others = [bytes_ for other, bytes_ in self.job_names() if other != name]
        return len(others) >= _MOST_JOBS or sum(others) + size > MOST_BYTES
