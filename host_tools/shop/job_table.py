"""The shop's book: every job, which machine has it, and how it ended. An SQLite file. Every change is on the disk before its call returns.

    book = JobTable(Path("shop.sqlite"))
    book.add_jobs(data, "cat.svg", {"kind": "corexy_plotter"}, copies=30)
    job = book.give_job("plotter-3", nonce, fits)  # the first queued job for which fits(job); it is that machine's from now on
    book.open_of("plotter-3")               # the job that the machine has, or None
    book.end(job, "done", line, text)

A job is given to one machine, once. Only that machine's word ends it: a message that the broker loses or delivers twice changes nothing.

Each call raises JobTableError if the disk is full, or another program has the file for longer than a moment: then nothing has changed, and the
call may be made again.
"""

import contextlib
import errno
import hashlib
import json
import os
import sqlite3
import threading
import time
from typing import NamedTuple, Optional

QUEUED, GIVEN, BEGUN, WAITING = "queued", "given", "begun", "waiting"
OPEN = (GIVEN, BEGUN, WAITING)
DONE = "done"
LEFT = "left"  # ended on the shop's page, for its machine was not reached
_WRONG_CALLS = sqlite3.IntegrityError, sqlite3.ProgrammingError, sqlite3.DataError, sqlite3.NotSupportedError  # no fault of the file
_TROUBLE_S = 3.0  # longer than between two attempts
_WAIT_MS = 200  # for another program that has the file: STOP must not wait for it
_TABLES = """
create table if not exists files (sha text primary key, data blob not null);
create table if not exists jobs (
    id text primary key, number integer not null unique, name text not null, sha text not null, wants text not null, state text not null,
    machine text, nonce text, line integer not null default 0, text text not null default '', added real not null, begun real, ended real
);
create index if not exists jobs_state on jobs (state, number);
create index if not exists jobs_sha on jobs (sha);
create unique index if not exists one_a_machine on jobs (machine) where state in ('given', 'begun', 'waiting');
"""
_IS_OPEN = "state in ('given', 'begun', 'waiting')"  # as the index has it


class JobTableError(OSError):
    """The book could not be read or written; `strerror`: why."""


class Job(NamedTuple):
    id: str  # eight hexadecimal digits: the board's journal knows the job by it
    number: int  # in the order of the queue
    name: str
    sha: str  # of its file
    wants: dict
    state: str  # QUEUED, GIVEN, BEGUN, WAITING, or how it has ended
    machine: Optional[str]
    nonce: Optional[str]  # of the machine, for which it was given
    line: int
    text: str
    added: float
    begun: Optional[float]
    ended: Optional[float]


def _job_of(row):
    return Job(*row[:4], json.loads(row[4]), *row[5:])


class JobTable:
    """Calls may come from several threads."""

    def __init__(self, path):
        self._lock = threading.RLock()
        self._base = sqlite3.connect(path, check_same_thread=False, isolation_level=None)
        self._base.executescript("pragma journal_mode=wal; pragma synchronous=full;" + _TABLES + f"pragma busy_timeout={_WAIT_MS};")
        self._failed = "", 0.0  # why, and when
        self.changed = 0  # counts

    @property
    def trouble(self):
        """The reason why the file could not be read or written in the last _TROUBLE_S; "": it could."""
        why, failed_s = self._failed
        return why if time.monotonic() - failed_s < _TROUBLE_S else ""

    def close(self):
        self._base.close()

    @contextlib.contextmanager
    def _open_base(self):
        """The base for one thread. Raises JobTableError if its file cannot be read or written."""
        with self._lock:
            try:
                yield self._base
            except sqlite3.DatabaseError as error:
                if isinstance(error, _WRONG_CALLS):
                    raise
                self._failed = str(error), time.monotonic()
                raise JobTableError(errno.EIO, str(error)) from error

    def _read_rows(self, text, *values):
        """Return the rows of a query. Raises JobTableError."""
        with self._open_base() as base:
            return base.execute(text, values).fetchall()

    def _change_rows(self, text, *values):
        """Change rows, and return how many. Raises JobTableError."""
        with self._open_base() as base:
            self.changed += 1
            count = base.execute(text, values).rowcount
            self._failed = "", 0.0
            return count

    def _select_jobs(self, text, *values):
        return [_job_of(row) for row in self._read_rows("select * from jobs " + text, *values)]

    # --- the queue

    def add_jobs(self, data, name, wants, copies=1):
        """Queue `copies` jobs of a file, all or none; returns their ids. `data`: its bytes; `wants`: properties that a machine must have."""
        sha = hashlib.sha256(data).hexdigest()
        with self._open_base() as base:
            base.execute("begin immediate")
            try:
                self._change_rows("insert or ignore into files values (?, ?)", sha, data)
                number = self._read_rows("select coalesce(max(number), 0) from jobs")[0][0]
                ids = []
                while len(ids) < copies:
                    new = os.urandom(4).hex()
                    if int(new, 16) and not self.job_by_id(new):
                        ids.append(new)
                        self._change_rows(
                            "insert into jobs (id, number, name, sha, wants, state, added) values (?, ?, ?, ?, ?, ?, ?)",
                            new, number + len(ids), name, sha, json.dumps(wants), QUEUED, time.time(),
                        )  # fmt: skip
                base.execute("commit")
            except BaseException:
                if base.in_transaction:  # a full disk may have ended it
                    base.execute("rollback")
                raise
        return ids

    def give_job(self, machine, nonce, fits):
        """Give the machine the first queued job for which fits(job), and return it; None: there is none, or the machine has one already. `nonce`: of
        the machine's release."""
        with self._open_base() as base:
            if self.open_of(machine):
                return None
            with contextlib.closing(base.execute("select * from jobs where state = ? order by number", (QUEUED,))) as waiting:
                job = next((job for job in map(_job_of, waiting) if fits(job)), None)  # without reading the rest of a long queue
            if job is None:
                return None
            self._change_rows("update jobs set state = ?, machine = ?, nonce = ? where id = ? and state = ?", GIVEN, machine, nonce, job.id, QUEUED)
            return self.job_by_id(job.id)

    def note_progress(self, job, state, line, text):
        """Write down state, line and text of a job that a machine has. Does not wait for the disk: the machine will say so again."""
        if job.state in OPEN and (job.state, job.line, job.text) != (state, line, text):
            begun = None if state == GIVEN else time.time()
            with self._open_base() as base:
                base.execute("pragma synchronous=normal")
                try:
                    self._change_rows("update jobs set state = ?, line = ?, text = ?, begun = coalesce(begun, ?) where id = ?", state, line, text, begun, job.id)
                finally:
                    base.execute("pragma synchronous=full")

    def end(self, job, how, line, text):
        """End a job as `how` at `line` with `text`. A job that is DONE and has no beginning yet, because it was short, begins with its end."""
        if job.state in OPEN:
            now = time.time()
            begun = now if how == DONE else None
            self._change_rows("update jobs set state = ?, line = ?, text = ?, begun = coalesce(begun, ?), ended = ? where id = ?", how, line, text, begun, now, job.id)

    def reopen_job(self, job_id, machine):
        """Give a job that was ended on the page back to its machine, which has spoken of it again."""
        job = job_id and self.job_by_id(job_id)
        if job and job.state == LEFT and job.machine == machine and not self.open_of(machine):
            self._change_rows("update jobs set state = ?, text = '', ended = null where id = ?", BEGUN if job.begun else GIVEN, job_id)

    def withdraw_job(self, job_id):
        """Remove a job from the queue. Return False if a machine has it already."""
        return self._change_rows("delete from jobs where id = ? and state = ?", job_id, QUEUED) > 0

    # --- reading

    def job_by_id(self, job_id):
        """The job with this id; None: there is none."""
        return next(iter(self._select_jobs("where id = ?", job_id)), None)

    def open_of(self, machine):
        """The job that a machine has and that has not ended; None: it has none."""
        return next(iter(self._select_jobs("where machine = ? and " + _IS_OPEN, machine)), None)

    def has_open_job(self, sha):
        """True if a machine has a job of this file."""
        return bool(self._select_jobs(f"where sha = ? and {_IS_OPEN} limit 1", sha))

    def jobs(self, most=500):
        """The jobs that have not ended, then the newest others, `most` at most."""
        return self._select_jobs("order by state in ('queued', 'given', 'begun', 'waiting') desc, ended desc, number limit ?", most)

    def count_states(self):
        """{state: number of jobs}"""
        return dict(self._read_rows("select state, count(*) from jobs group by state"))

    def times_of_materials(self):
        """[[material, jobs done, seconds from begin to end]] of the jobs that are done."""
        return self._read_rows("select coalesce(json_extract(wants, '$.material'), ''), count(*), sum(max(ended - begun, 0)) from jobs where state = 'done' group by 1 order by 1")

    def file_data(self, sha):
        """The bytes of a job's file."""
        return self._read_rows("select data from files where sha = ?", sha)[0][0]
