"""Stored jobs on the page that a board serves: uploaded in pieces, listed, run, deleted.

    jobs = StoredJobs(machine, tell, language)
    machine.orders["stored"]({"do": "stored", "what": "begin", "name": "PART.NC", "size": 900, "crc": "cbf43926", "stored": 300})
    machine.orders["stored"]({"do": "stored", "what": "piece", "name": "PART.NC", "at": 0, "data": "…"})    # base64, PIECE bytes
    machine.orders["stored"]({"do": "stored", "what": "end", "name": "PART.NC"})    # read back whole; the job "kept" or "failed" follows
    jobs.poll()                     # before the state is pushed

The commands are those of the `$F` lines of every language (language_grbl.py): the machine refuses them while anything moves, and
without the command. An upload never is in memory: a piece is written before the next is asked for, and the browser has packed it.
"""

from binascii import a2b_base64

from micropython import const

from passo import commands, errors
from passo.commands import Command
from passo.options.jobs.commands import JOB, JOB_CLOSE, JOB_DATA, JOB_DELETE, JOB_LIST, JOB_OPEN, JOB_RUN, JOB_STATE
from passo.options.jobs.config_names import name_fits
from passo.options.jobs.errors import JOB_STOPPED, JOB_UPLOAD, STORED_NAME
from passo.protocols.page.orders import Wrong, number_field, text_field

PIECE = const(300)  # bytes of an upload in a message: with its proof some 600, of which a Pico W has several pieces at any time
_BASE64 = const(400)  # letters of it
_MOST_BYTES = const(0x0FFFFFFF)
_PER_CENT = const(100)


class StoredJobs:
    def __init__(self, machine, tell, language):
        """`machine`: a PageMachine; `tell(event)`: a dict for every page."""
        self._machine = machine
        self._tell = tell
        self._language = language
        self._name = ""  # of the upload under way
        self._sent = self._size = 0
        self._closing = self._ran = False
        machine.add_stored_jobs(self._carry_out, JOB, self._take_event)

    def _carry_out(self, order):
        """Carry out an order: `what` is list, run, delete, begin, piece or end. Returns 0 or an error. Raises Wrong."""
        machine = self._machine
        what = text_field(order, "what", 8)
        error = machine.refusal() or machine.busy_error() or (errors.BUSY if self._closing else 0)
        if error:
            return error
        if what == "list":
            return self._queue_job_command(JOB_LIST)
        name = text_field(order, "name", 64)
        if not name_fits(name):
            return STORED_NAME
        if what == "run" or what == "delete":
            return self._queue_job_command(JOB_RUN if what == "run" else JOB_DELETE, name)
        if what == "begin":
            return self._begin_upload(order, name)
        if name != self._name:
            return JOB_UPLOAD
        if what == "piece":
            return self._store_piece(order)
        return self._end_upload() if what == "end" else errors.UNKNOWN_COMMAND

    def _queue_job_command(self, what, target=None, answered=None):
        """Queue a command about jobs; `what`: JOB_LIST …; answered(error) follows. Returns 0 or an error."""
        return self._machine.queue_command(Command(JOB, target, what), answered or self._ignore_answer)

    def _ignore_answer(self, error):
        """Do nothing: the answer to the order has the error."""

    # --- uploads

    def _begin_upload(self, order, name):
        """Open a job on the board for an upload, by the order's size, CRC-32 and packed size. Returns 0 or an error. Raises Wrong."""
        size = int(number_field(order, "size", 1, _MOST_BYTES))
        stored = int(number_field(order, "stored", 1, _MOST_BYTES))
        try:
            crc = int(text_field(order, "crc", 8), 16)
        except ValueError:
            raise Wrong("crc")
        self._name = ""

        def begin_pieces(error):
            if not error:
                self._name, self._sent, self._size = name, 0, stored

        return self._queue_job_command(JOB_OPEN, (name, self._language, size, crc, stored), begin_pieces)

    def _store_piece(self, order):
        """Store the next piece of the upload, in base64. Returns 0 or an error. Raises Wrong."""
        if number_field(order, "at", 0, _MOST_BYTES) != self._sent:
            return errors.JOB_PIECE
        try:
            data = a2b_base64(text_field(order, "data", _BASE64))
        except ValueError:
            raise Wrong("data")

        def count_piece(error):
            if not error:
                self._sent += len(data)
                self._show_job("store", self._name, self._sent * _PER_CENT // self._size)

        return self._queue_job_command(JOB_DATA, data, count_piece)

    def _end_upload(self):
        """Close the upload; the board reads it back. Returns 0 or an error."""
        self._closing = True
        return self._queue_job_command(JOB_CLOSE)

    # --- what the machine says

    def _take_event(self, event):
        """Take the answer to a command about jobs: send the list, or show how the job stands."""
        what = event.command.value
        if what == JOB_CLOSE and self._closing:
            self._closing = False
            self._show_job("failed" if event.error else "kept", self._name, _PER_CENT, event.error)
            self._name = ""
        elif event.kind == commands.ACCEPTED and what == JOB_LIST:
            found, (free, more) = event.value
            self._tell({"t": "stored", "jobs": [[entry[0], entry[2]] for entry in found], "free": free, "more": more, "piece": PIECE})
        elif event.kind == commands.ACCEPTED and what == JOB_STATE:
            if len(event.value) == 2:
                self._show_job("run", event.value[0], event.value[1])
            else:
                name, error, line = event.value
                self._show_job("failed" if error else "done", name, _PER_CENT, error, line)

    def poll(self):
        """Ask for the progress of a stored job that runs; end an upload that a stop has cut while it was read back."""
        machine = self._machine
        if self._closing and not machine.busy_with(JOB):
            self._closing = False
            self._show_job("failed", self._name, _PER_CENT, JOB_STOPPED)
        runs = machine.runs_stored()
        if runs or self._ran:
            self._ran = runs
            self._queue_job_command(JOB_STATE)

    def _show_job(self, how, name, done, error=0, line=0):
        """Show a stored job on all pages; `done`: per cent."""
        self._machine.state["job"] = {
            "name": name, "how": how, "error": error, "line": line, "lines": _PER_CENT, "done": done,
            "pass": 1, "passes": 1, "checked": False, "single": False, "stored": True,
        }  # fmt: skip


def extend(protocol, board):
    protocol.add_jobs(StoredJobs)
