"""The jobs that a board keeps (docs/use/jobs.md), beside those that come line by line: listed, run, checked, deleted, stored.

    machine.job = StoredJobs(machine, tell, packed)
    machine.orders["stored"]({"do": "stored", "what": "list"})      # the event "stored" follows: names, bytes, and bytes free

`packed(name)`: (bytes, CRC-32, the packed bytes) of a job of the page's own as a board stores it (options/jobs/config.py), or the number of an
error. One line at a time goes to the board: as it writes its flash a Pico's processor stands still.
"""

from binascii import b2a_base64

from micropython import const

from host_tools.page.job import Job
from host_tools.page.slow_order import SlowOrder, is_refusal
from host_tools.clients.grbl_wire import PAGE
from passo import errors

_PIECE = const(54)  # bytes of an upload in a line
_LOST = const(60)  # reports; then the message that it has ended was lost
_WHOLE = const(100)  # a job's progress is in per cent


class StoredJobs(Job):
    def __init__(self, machine, tell, packed=None):
        """`tell(event)`: a dict for every page."""
        Job.__init__(self, machine)
        self._tell_pages = tell
        self._packed = packed
        self._kept = None  # "run", "check" or "store": the task under way
        self._upload = []  # lines that are still to be sent
        self._sent = 0
        self._waiting = False
        self._quiet = 0  # reports in a row of a machine at rest that know of no job
        self._found = []
        self._free = self._more = 0
        machine.orders["stored"] = self._carry_out

    def _carry_out(self, order):
        """Carry out an order about stored jobs: `what` is list, delete, run or store. Returns 0, an error or a SlowOrder."""
        machine = self._machine
        what, name = order.get("what"), order.get("name")
        error = machine.refusal() or machine.busy_error()
        if error:
            return error
        if what == "list" and machine.options is None:
            return errors.BUSY  # it has not said yet whether it keeps jobs
        if what == "list":
            self._found, self._more = [], 0
            if "F" not in machine.options:
                self._tell_list(errors.STATEMENT)
                return 0
            return 0 if machine.wire.send_line(PAGE, b"$F", self._tell_list) else errors.BUSY
        from passo.options.jobs.config_names import name_fits
        from passo.options.jobs.errors import STORED_NAME

        if not isinstance(name, str) or not name_fits(name):
            return STORED_NAME
        if what == "delete":
            return machine.send_line(b"$FD=" + name.encode())
        if what == "run":
            return self._start_job(name, "check" if order.get("check") else "run")
        if what == "store" and self._packed:
            job = order.get("job")
            return SlowOrder(lambda: self._packed(job), lambda found: machine.refusal() or machine.busy_error() or self._store_job(name, found), job) if isinstance(job, str) else errors.NO_SUCH_JOB
        return errors.UNKNOWN_COMMAND

    def _tell_list(self, error):
        """Send the list of stored jobs to all pages behind the answer to `$F`; an error: the board keeps no jobs."""
        self._tell_pages({"t": "stored", "jobs": None if error else self._found, "free": self._free, "more": self._more})

    # --- what the board says

    def take_line(self, line):
        """Take a line in brackets. Returns True if it lists stored jobs."""
        if line[:6] == "[FILE:":
            name, size = line[6:].split("|")[:2]
            self._found.append([name, int(size[5:])])
            return True
        if line[:6] == "[MORE:":
            self._more = int(line[6:-1])
            return True
        if line[:6] == "[FREE:":
            self._free = int(line[6:-1])
            return True
        if line[:9] == "[MSG:Job " and self._kept in ("run", "check"):
            if line[-6:] == " done]":
                self._finish_job("done", 0)
            else:
                words = line[:-1].split(" ")
                self._line = int(words[-1]) if "line" in words else 0
                self._finish_job("failed", int(words[words.index("error") + 1]) if "error" in words else errors.STOPPED)
        return False

    def report(self, state):
        """Take a report: follow a stored job's progress; end one that no report has named _LOST times in a row."""
        told = self._machine.state.get("stored")
        if told and not Job.is_running(self) and self._kept is None:
            self._begin_job(told.partition(",")[2], "run")  # begun by a button, or with the board
        if self._kept not in ("run", "check"):
            Job.report(self, state)
            return
        self._quiet = self._quiet + 1 if not told and state in ("Idle", "Check") else 0
        if told:
            self._sent = int(told.partition(",")[0])
        elif self._quiet > _LOST:
            self._finish_job("failed", errors.NO_ANSWER)
            return
        if self._halting and state in ("Hold", "Idle", "Alarm", "Check", "Door"):
            self._machine.stop()

    # --- running

    def is_running(self):
        return self._kept is not None or Job.is_running(self)

    def _begin_job(self, name, what):
        """Begin the job `name` on the pages; `what`: store, run or check."""
        self.name = name
        self._kept = what
        self._sent = self._line = self._failed = self._quiet = 0
        self._halting = False
        self._tell_kept("store" if what == "store" else "run", 0)

    def _start_job(self, name, what):
        """Have the board run a stored job, or check it. Returns 0 or an error."""
        machine = self._machine
        if machine.state["state"] not in ("Idle", "Alarm") or not machine.wire.has_room(len(name) + 8):
            return errors.BUSY
        self._begin_job(name, what)
        if what == "check":
            machine.send_line(b"$C")
        machine.wire.send_line(PAGE, b"$F=" + name.encode(), self._take_run_answer)
        return 0

    def _take_run_answer(self, error):
        if error > 0 and self._kept in ("run", "check"):
            self._finish_job("failed", error)

    def abort(self):
        """Hold the machine to end a stored job, end an upload, or abort a streamed job. Returns 0."""
        if self._kept is None:
            return Job.abort(self)
        if self._kept == "store":
            self._finish_job("failed", errors.STOPPED)
            return 0
        self._halting = True
        self._failed = errors.STOPPED
        self._machine.hold()
        return 0

    def fail(self, error):
        """End the job under way as failed with an error from outside."""
        if self._kept is None:
            Job.fail(self, error)
        else:
            self._finish_job("failed", self._failed or error)

    def _finish_job(self, how, error):
        """End the stored job or the upload; show `how` and `error` on all pages."""
        kept = self._kept
        if kept is None:
            return
        self._tell_kept("kept" if kept == "store" and not error else how, error)
        self._kept = None
        self._upload = []
        self._machine.state["stored"] = ""  # not every report tells it
        if kept == "check":
            self._machine.leave_check()

    # --- storing

    def _store_job(self, name, found):
        """Begin to upload a job in lines of _PIECE bytes. `found`: (bytes, CRC-32, packed bytes), or a refusal. Returns 0 or the refusal."""
        if is_refusal(found):
            return found
        size, crc, packed = found
        self._upload = [b"$FS=%s,grbl,%d,%08x,%d" % (name.encode(), size, crc, len(packed))]
        for at in range(0, len(packed), _PIECE):
            self._upload.append(b"$F:" + b2a_base64(packed[at : at + _PIECE]).strip())
        self._upload.append(b"$FE")
        self._waiting = False
        self._begin_job(name, "store")
        self._count = len(self._upload)
        return 0

    def poll(self):
        """Send lines of a streamed job, or the next line of an upload once the last one is answered."""
        Job.poll(self)
        if self._upload and not self._waiting and self._kept == "store":
            self._waiting = self._machine.wire.send_line(PAGE, self._upload[0], self._take_piece_answer)

    def _take_piece_answer(self, error):
        """Take the answer to a line of the upload; end it at an error, or behind its last line."""
        self._waiting = False
        if self._kept != "store":
            return
        if error:
            self._finish_job("failed", errors.STOPPED if error < 0 else error)
            return
        self._upload.pop(0)
        self._sent = _WHOLE - len(self._upload) * _WHOLE // self._count
        if not self._upload:
            self._finish_job("done", 0)

    # --- the state

    def _tell_kept(self, how, error):
        """Show the stored job's state on the pages: `how`, an error's number or 0, and the parts done of _WHOLE."""
        self._machine.state["job"] = {
            "name": self.name, "how": how, "error": error, "line": self._line, "lines": _WHOLE, "done": _WHOLE if how in ("done", "kept") else self._sent,
            "pass": 1, "passes": 1, "checked": self._kept == "check", "single": False, "stored": True,
        }  # fmt: skip

    def refresh_state(self):
        """Bring the state's "job" up to date for the pages."""
        if self._kept is None:
            Job.refresh_state(self)
        else:
            self._tell_kept("halting" if self._halting else "store" if self._kept == "store" else "run", 0)
