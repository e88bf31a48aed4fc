"""Stored jobs: uploaded, listed, deleted, and run by a command, by a button or at the start.

A job is the bytes that a PC would send. It runs by a link of its own, whose serial line reads the file: the language understands it as it
understands a PC, and the steps are the same. While it runs that link commands; the link that commanded before may hold, go on, override and
stop. The first line of a job that is refused ends it: no line after it is carried out.

Each time before it runs, a job is read to its end and its CRC compared: nothing of a damaged file moves the machine. It is
read again while it runs, behind a line that is refused too; if it is not the same then, the machine comes to a stand, with an alarm.
A card that is taken out ends the job at a stand, without one: all that was read before is right.

Reading goes on in the main loop while steps are made in an interrupt: it takes time from the lines, none from the steps.
"""

from micropython import const

from passo import commands, errors
from passo.commands import DROPPED, Event
from passo.control.feature import OFF, WORK_GONE, Feature
from passo.arrays import buffer
from passo.control.links import OF_LENDER, RIGHTS, STARTS
from passo.errors import ALARMS, AT_STAND, OUTPUTS_OFF
from passo.options.jobs.commands import JOB, JOB_CLOSE, JOB_DATA, JOB_DELETE, JOB_LIST, JOB_OPEN, JOB_RUN, JOB_STATE
from passo.options.jobs.config import Damaged, JobStore
from passo.options.jobs.config_names import LINK, name_fits
from passo.options.jobs.errors import (
    ALARM_JOB_CHANGED, JOB_DAMAGED, JOB_LANGUAGE, JOB_MEMORY, JOB_RUNS, JOB_SPACE, JOB_STOPPED, JOB_UPLOAD, NOTICE_JOB_ENDED, NO_CARD, NO_JOB, STORED_NAME,
)  # fmt: skip

_PIECE = const(512)  # bytes that are read at once while a job is proven
_CHECKED = const(16)  # such pieces a cycle: some 12 ms on a Pico


class JobLine:
    """The serial line of a stored job: reads the file, counts the answers, and waits while the language has as many units unanswered
    as it may."""

    def __init__(self, protocol, look, damaged):
        """`protocol`: of the link, whose `stored` says how its answers are counted. Calls `look()` at each answer, `damaged(error)` if the file is
        damaged."""
        self._protocol = protocol
        limits, self._frame, self._units, self._answers = protocol.stored
        self._most, piece = limits  # units that may be unanswered: lines, packets, codes
        self.piece = memoryview(buffer(max(piece, _PIECE)))  # a job is checked with it
        self._view = self.piece[:piece]  # on the bytes read last
        self._look_at_log = look
        self._damaged = damaged
        self._first = self._last = b""  # the bytes before the file, and after it, that are still to be given
        self._file = None
        self.given = self.answered = 0  # units

    def begin(self, file):
        """Give the bytes of `file`, a JobFile, from here on."""
        self._file = file
        self.given = self.answered = 0
        self._first, self._last = self._frame
        getattr(self._protocol, "begin_file", int)()

    def leave_file(self):
        """Give nothing more of the file. Returns it, or None if there is none."""
        file = self._file
        self._file = None
        return file

    def any(self):
        """Return True if there are bytes, and few enough units are unanswered."""
        file = self._file
        return file is not None and (file.done < file.size or self._last) and self.given - self.answered < self._most

    def read(self):
        """Bytes of the job, good until the next read; b"" if there are none, or too many are not answered."""
        if not self.any():
            return b""
        data = self._first
        if data:
            self._first = b""
        elif self._file.done == self._file.size:
            data = self._last
            self._last = b""
        else:
            try:
                count = self._file.readinto(self._view)
            except Damaged as damaged:
                self._damaged(damaged.args[0])
                return b""
            data = self._view[:count]
        self.given += self._units(data)
        return data

    def write(self, data):
        """Count the answers in `data`."""
        if self._file is not None:
            self.answered = self._answers(bytes(data), self.answered, self.given)
            self._look_at_log()

    def is_done(self):
        """Return True if all of the file has been given and answered."""
        file = self._file
        return file.done == file.size and not self._last and self.given == self.answered


class Jobs(Feature):
    event_mask = WORK_GONE

    def __init__(self, board, machine, queue):
        config = board["jobs"]
        Feature.__init__(self, board, machine, queue)
        self._config = config
        folder = getattr(machine.port, "folder", None) or config["folder"]
        self._card = None
        self._store = self._make_store(board, machine.port, folder)
        self._start = config["start"]
        self.line = None
        self._number = 0  # of the link
        self._name = ""  # of the job under way
        self._file = None
        self._failed = 0  # the error that has ended it; it is still coming to its stand
        self._ended = "", 0, 0  # the last one: its name, error, line
        self._noted = 0  # how many entries the log had
        self._reading = None  # the upload that is read back
        self._proving = False  # the job is read to its end before it runs
        self._rest = None  # its file, read to its end behind a line that was refused
        machine.links.append(LINK)

    def join(self, number, protocol):
        """Take the link's `number` and its `protocol`. Returns the serial line that reads the file."""
        self._number = number
        self.line = JobLine(protocol, self._look_at_log, self._stop_job)
        return self.line

    def _make_store(self, board, port, folder):
        """Return the store in the board's flash, mounted."""
        store = JobStore(folder)
        store.mount()
        return store

    def handlers(self):
        RIGHTS[JOB] = OF_LENDER | STARTS
        ALARMS[ALARM_JOB_CHANGED] = AT_STAND | OUTPUTS_OFF
        return {JOB: self._do_job}

    def busy(self):
        """Return True while a job runs, or is read before it."""
        return self._file is not None

    def report(self, report):
        file = self._file
        report["job"] = None if file is None else "%d,%s%s" % (self._per_cent(), self._name, "?" if self._proving else "")

    # --- commands

    def _do_job(self, command):
        """Do JOB. Returns the number of an error, or 0; one of a button is logged and shown."""
        try:
            error = self._do_order(command)
        except Damaged as damaged:
            error = damaged.args[0]
        except MemoryError:
            self._store.abort_upload()
            error = JOB_MEMORY
        except OSError:
            self._store.abort_upload()
            error = NO_JOB if command.value in (JOB_RUN, JOB_DELETE) else self._mount_card() or JOB_SPACE
        if error and command.link is None:  # a button, or the start: there is nobody to answer
            name = command.target or self._config["button"]
            self._machine.note(error, name)
            self._machine.notice(NOTICE_JOB_ENDED, (name, error, 0))
        return error

    def _mount_card(self):
        """Mount the memory card, if the board has one. Returns the number of an error."""
        if self._card is not None and not self._store.busy():
            try:
                self._card.mount()
                self._store.mount()
            except (OSError, ImportError):
                return NO_CARD
        return 0

    def _do_order(self, command):
        """Carry out an order about stored jobs. Returns the number of an error, or 0. Raises Damaged, MemoryError, OSError."""
        machine = self._machine
        what = command.value
        if what == JOB_STATE:
            return machine.confirm_command(command, self._ended if self._file is None else (self._name, self._per_cent()))
        if what == JOB_RUN:
            return self._run_job(command, command.target or self._config["button"])
        if self._file is not None:
            return JOB_RUNS
        if machine.state not in ("idle", "alarm") or not self._queue.still():
            return errors.BUSY
        machine.port.feed_watchdog()
        error = self._mount_card() if what in (JOB_LIST, JOB_DELETE, JOB_OPEN) else 0
        if error:
            return error
        if what == JOB_LIST:
            return machine.confirm_command(command, (self._store.list_jobs(), (self._store.free_bytes(), self._store.more)))
        if what == JOB_CLOSE:
            self._reading = self._store.open_upload()
            if self._reading is None:
                return JOB_UPLOAD
            return machine.begin(command, self._read_upload)
        if what == JOB_DATA:
            error = self._store.add_data(command.target)
        elif what == JOB_OPEN:
            error = self._begin_upload(*command.target)
        elif name_fits(command.target):
            self._store.delete_job(command.target)
        else:
            return NO_JOB
        return error or machine.confirm_command(command)

    def _begin_upload(self, name, language, size, crc, stored):
        """Begin an upload, if its name, language and size are right. Returns the number of an error, or 0."""
        if not name_fits(name):
            return STORED_NAME
        if language != self._config["language"]:
            return JOB_LANGUAGE
        if stored > self._store.free_bytes():
            return JOB_SPACE
        self._store.begin(name, language, size, crc, stored)
        return 0

    # --- running

    def _run_job(self, command, name):
        """Open a job, and give its link the command; it is read to its end before it runs. Returns the number of an error, or 0."""
        machine = self._machine
        if self._file is not None:
            return JOB_RUNS
        if not name_fits(name):
            return NO_JOB
        if machine.alarm not in (0, errors.ALARM_LOCKED, errors.ALARM_HOMING_REQUIRED):  # the job may home first
            return errors.LOCKED
        if machine.state not in ("idle", "alarm", "check") or not self._queue.still():
            return errors.BUSY
        error = self._mount_card()
        if error:
            return error
        self._file = self._store.open(name, self._config["language"])
        self._name = name
        self._failed = 0
        self._proving = True
        machine.lender = machine.commander
        machine.commander = self._number
        return 0 if command.link is None else machine.confirm_command(command)

    def _per_cent(self):
        """Return how much of the file has been read, in per cent."""
        return self._file.done * 100 // max(self._file.size, 1)

    def _read_on(self, file):
        """Read _CHECKED pieces. Returns None if there is more, 0 at the end of a file that is right, or the number of an error."""
        try:
            for _ in range(_CHECKED):
                if not file.readinto(self.line.piece):
                    return 0
        except Damaged as damaged:
            return damaged.args[0]
        return None

    def _prove_on(self):
        """Read on in the proof of the job; at its end begin the job, or end it with the error."""
        try:
            error = self._read_on(self._file)
            if error == 0:
                self._begin_job()
        except Damaged as damaged:
            error = damaged.args[0]
        except OSError:
            error = NO_CARD if self._card else JOB_DAMAGED
        except MemoryError:
            error = JOB_MEMORY
        if error:
            self._machine.note(error, self._name)
            self.line.answered = 0
            self._end_job(error)

    def _begin_job(self):
        """Begin the job that has been proven. Raises Damaged if its CRC is another one now, OSError, MemoryError."""
        machine = self._machine
        proven = self._file
        self._proving = False
        self._store.close(proven)
        self._file = self._store.open(self._name)
        self.line.begin(self._file)
        if self._file.crc != proven.crc:
            raise Damaged(JOB_DAMAGED)
        self._announce_job(self._file.crc or 1)
        self._noted = machine.log.count

    def _announce_job(self, number):
        """Announce the job to the journal; 0: the last one is done."""
        journal = self._machine.handlers.get(commands.JOURNAL)
        if journal and not self._machine.checking:
            journal(commands.Command(commands.JOURNAL, number))

    def poll(self, now_ms):
        """Begin the job of the start; prove the job, or look whether one of its lines was refused."""
        if self._start:
            name = self._start
            self._start = ""
            self._do_job(commands.Command(JOB, name))
        if self._file is not None:
            self._machine.awake = True
            if self._proving:
                self._prove_on()
            else:
                self._look_at_log()

    def _look_at_log(self):
        """Stop the job if the newest entry of the log says that one of its lines was refused."""
        log = self._machine.log
        if log.count != self._noted:
            self._noted = log.count
            newest = log.newest()
            if not self._failed and newest[2] == LINK:
                self._stop_job(newest[1])

    def _stop_job(self, error):
        """Give no more lines, and bring the machine to a stand: a line was refused, or the file cannot be read on."""
        if self._failed or self._file is None:
            return
        machine = self._machine
        self._failed = error
        file = self.line.leave_file()
        machine.tell(Event(DROPPED, None, error))
        if commands.HOLD in machine.handlers and self._config["language"] != "pulses":
            machine.drop_at_stand()
        else:
            machine.carry_out(commands.STOP)
        self._rest = file
        if error in (JOB_DAMAGED, NO_CARD):
            self._note_unread(error)

    def _read_rest(self):
        """Read the file to its end behind a refused line: a changed file or a card taken out is the cause then."""
        error = self._read_on(self._rest)
        if error:
            self._note_unread(error)
        elif error == 0:
            self._rest = self._close_job(self._rest)

    def _note_unread(self, error):
        """Log the error of a file that cannot be read on, and close it."""
        self._failed = error
        self._machine.note(error, self._name)
        self._rest = self._close_job(self._rest)

    def _close_job(self, file):
        """Close a job, if there is one. Returns None."""
        if file is not None:
            self._store.close(file)

    def _read_upload(self, _):
        """Read an upload back, and make it the job if it is right."""
        machine = self._machine
        error = self._read_on(self._reading)
        if error is None:
            return
        self._reading = self._close_job(self._reading)
        if not error:
            machine.port.feed_watchdog()
            try:
                self._store.commit_upload()
            except OSError:
                error = JOB_SPACE
        if error:
            self._store.abort_upload()
            command = machine.command
            machine.command = None
            machine.note(error, command.link.name if command.link else "")
            machine.tell(Event(commands.REFUSED, command, error))
        else:
            machine.finish()

    def poll_end(self, still):
        """End the job at a stand: it is done, or was stopped."""
        machine = self._machine
        if self._file is None or self._proving or not still or machine.dropping or machine.command is not None or machine.drawing or machine.active:
            return
        if self._rest is not None:
            self._read_rest()
        elif self._failed:
            machine.inform(OFF)
            self._end_job(self._failed)
            if self._failed == JOB_DAMAGED:
                machine.raise_alarm(ALARM_JOB_CHANGED, self._name)
        elif self.line.is_done():
            self._announce_job(0)
            self._end_job(0)

    def on_events(self, _):
        """End the job: a stop, a reset or an alarm has dropped all work."""
        self._rest = self._close_job(self._rest)
        if self._reading is not None:
            self._reading = self._close_job(self._reading)
            self._store.abort_upload()
        if self._file is not None and not self._failed:
            command = self._machine.command
            if command is not None and command.link is not None and command.link.name == LINK:  # its line will have no answer
                self.line.answered += 1
            self._end_job(JOB_STOPPED)

    def _end_job(self, error):
        """Close the file, give the command back to the link before, and say how the job has ended."""
        machine = self._machine
        rest = self.line.leave_file()
        self._file = self._close_job(self._file if self._proving else rest)
        self._proving = False
        machine.commander = machine.lender
        machine.lender = -1
        self._ended = self._name, error, self.line.answered
        machine.notice(NOTICE_JOB_ENDED, self._ended)
