"""Stored jobs: uploaded, listed, deleted, and run by a command, by a button or at the start.

A job is the bytes that a PC would send. It runs by a link of its own, whose serial line reads the file: the language
understands it as it understands a PC, and the steps are the same. While it runs that link commands; whoever commanded before
may hold, go on, override and stop. Nothing of a job is done behind the first line that is refused.

Each time before it runs, a job is read to its end and its CRC compared: nothing of a damaged file moves the machine. It is
read again while it runs, behind a line that is refused too; if it is not the same then, the machine comes to a stand, with an alarm.
A card that is taken out ends the job at a stand, without one: all that was read before is right.

Reading goes on in the main loop while steps are made in an interrupt: it takes time from the lines, none from the steps.
"""

from micropython import const

from passo import commands, errors
from passo.commands import DROPPED, Event
from passo.config.job_keys import LINK, name_fits
from passo.config.job_store import Damaged, JobStore
from passo.control.feature import OFF, WORK_GONE, Feature
from passo.control.job_line import JobLine

_CHECKED = const(16)  # such pieces a cycle: some 12 ms on a Pico


class Jobs(Feature):
    heeds = WORK_GONE

    def __init__(self, board, machine, queue):
        config = board["jobs"]
        Feature.__init__(self, board, machine, queue)
        self._config = config
        folder = getattr(machine.port, "folder", None) or config["folder"]
        self._card = None
        if board["card"]:
            from passo.config.card_store import CardStore

            self._card = machine.port.make("memory_card", board["card"])
            self._store = CardStore(self._card.path + folder)
        else:
            self._store = JobStore(folder)
            self._store.mount()
        self._start = config["start"]
        self.line = JobLine()
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

    def join(self, number, protocol, stored):
        """`number` and `protocol` of the link; `stored`: what its language says of stored jobs. Returns the serial line."""
        self._number = number
        self.line.join(protocol, stored, self._look, self._refused)
        self._store.prepare()
        return self.line

    def handlers(self):
        return {commands.JOB: self._job}

    def busy(self):
        return self._file is not None

    def report(self, report):
        file = self._file
        report["job"] = None if file is None else "%d,%s%s" % (self._per_cent(), self._name, "?" if self._proving else "")

    # --- commands

    def _job(self, command):
        try:
            error = self._ask(command)
        except Damaged as damaged:
            error = damaged.args[0]
        except MemoryError:
            self._store.abort()
            error = errors.JOB_MEMORY
        except OSError:
            self._store.abort()
            error = errors.NO_JOB if command.value in (commands.JOB_RUN, commands.JOB_DELETE) else self._mount() or errors.JOB_SPACE
        if error and command.link is None:  # a button, or the start: there is nobody to answer
            name = command.target or self._config["button"]
            self._machine.note(error, name)
            self._machine.notice(errors.NOTICE_JOB_ENDED, (name, error, 0))
        return error

    def _mount(self):
        """Make sure of the memory card, if there is to be one. Returns the number of an error."""
        if self._card is not None and not self._store.busy():
            try:
                self._card.mount()
                self._store.mount()
            except (OSError, ImportError):
                return errors.NO_CARD
        return 0

    def _ask(self, command):
        machine = self._machine
        what = command.value
        if what == commands.JOB_STATE:
            return machine.accepted(command, self._ended if self._file is None else (self._name, self._per_cent()))
        if what == commands.JOB_RUN:
            return self._run(command, command.target or self._config["button"])
        if self._file is not None:
            return errors.JOB_RUNS
        if machine.state not in ("idle", "alarm") or not self._queue.still():
            return errors.BUSY
        machine.port.feed_watchdog()
        if what in (commands.JOB_LIST, commands.JOB_DELETE, commands.JOB_OPEN):
            error = self._mount()
            if error:
                return error
        if what == commands.JOB_LIST:
            return machine.accepted(command, (self._store.entries(), (self._store.free(), self._store.more)))
        if what == commands.JOB_DELETE:
            if not name_fits(command.target):
                return errors.NO_JOB
            self._store.delete(command.target)
        elif what == commands.JOB_OPEN:
            error = self._open(command)
            if error:
                return error
        elif what == commands.JOB_DATA:
            error = self._store.add(command.target)
            if error:
                return error
        else:
            self._reading = self._store.uploaded()
            if self._reading is None:
                return errors.JOB_UPLOAD
            machine.command = command
            return 0
        return machine.accepted(command)

    def _open(self, command):
        name, language, size, crc, stored = command.target
        if not name_fits(name):
            return errors.STORED_NAME
        if language != self._config["language"]:
            return errors.JOB_LANGUAGE
        if stored > self._store.free():
            return errors.JOB_SPACE
        self._store.begin(name, language, size, crc, stored)
        return 0

    # --- running

    def _run(self, command, name):
        machine = self._machine
        if self._file is not None:
            return errors.JOB_RUNS
        if not name or not name_fits(name):
            return errors.NO_JOB
        if machine.alarm not in (0, errors.ALARM_LOCKED):  # the job may home first
            return errors.LOCKED
        if machine.state not in ("idle", "alarm", "check") or not self._queue.still():
            return errors.BUSY
        error = self._mount()
        if error:
            return error
        file = self._store.open(name)
        if file.language != self._config["language"]:
            self._store.close(file)
            return errors.JOB_LANGUAGE
        self._store.begin_reading(file)
        self._file = file
        self._name = name
        self._failed = 0
        self._proving = True
        machine.lender = machine.commander
        machine.commander = self._number
        if command.link is not None:
            return machine.accepted(command)
        return 0

    def _per_cent(self):
        """How much of the file has been read."""
        return self._file.done * 100 // max(self._file.size, 1)

    def _prove(self):
        """Read on; at the end, if the job is right, begin it."""
        try:
            for _ in range(_CHECKED):
                if not self._file.readinto(self.line.piece):
                    self._begin()
                    return
        except Damaged as damaged:
            self._fail(damaged.args[0])
        except OSError:
            self._fail(errors.NO_CARD if self._card else errors.JOB_DAMAGED)
        except MemoryError:
            self._fail(errors.JOB_MEMORY)

    def _begin(self):
        machine = self._machine
        proven = self._file
        self._proving = False
        self._store.close(proven)
        self._file = self._store.open(self._name)
        self._store.begin_reading(self._file)
        self.line.begin(self._file, self._store)
        if self._file.crc != proven.crc:
            raise Damaged(errors.JOB_DAMAGED)
        self._announce(self._file.crc or 1)
        self._noted = machine.log.added

    def _announce(self, number):
        """Tell the journal which job begins; 0: the last one has been done to its end."""
        journal = self._machine.handlers.get(commands.JOURNAL)
        if journal and not self._machine.checking:
            journal(commands.Command(commands.JOURNAL, number))

    def _fail(self, error):
        """The job does not begin."""
        self._machine.note(error, self._name)
        self.line.answered = 0
        self._end(error)

    def poll(self, now_ms):
        if self._start:
            name = self._start
            self._start = ""
            self._job(commands.Command(commands.JOB, name))
        if self._file is not None:
            self._machine.awake = True
        if self._proving:
            self._prove()
        elif self._file is not None:
            self._look()

    def _look(self):
        """Notice at once if a line of the job was refused."""
        log = self._machine.log
        if log.added != self._noted:
            self._noted = log.added
            newest = log.newest()
            if not self._failed and newest[2] == LINK:
                self._refused(newest[1])

    def _refused(self, error):
        """A line was refused, or the file cannot be read on: nothing of the job is done any more."""
        if self._failed or self._file is None:
            return
        machine = self._machine
        self._failed = error
        file = self.line.leave()
        machine.tell(Event(DROPPED, None, error))
        if commands.HOLD in machine.handlers and commands.STEP_PROGRAM not in machine.handlers:
            machine.drop_at_stand()
        else:
            machine.carry_out(commands.STOP)
        self._rest = file
        if error in (errors.JOB_DAMAGED, errors.NO_CARD):
            self._unread(error)

    def _read_rest(self):
        """A file that has changed since it was proven, or a card that has gone, is why a line was refused."""
        try:
            for _ in range(_CHECKED):
                if not self._rest.readinto(self.line.piece):
                    self._close_rest()
                    return
        except Damaged as damaged:
            self._unread(damaged.args[0])

    def _unread(self, error):
        self._failed = error
        self._machine.note(error, self._name)
        self._close_rest()

    def _close_rest(self):
        if self._rest is not None:
            self._store.close(self._rest)
            self._rest = None

    def poll_command(self, now_ms):
        if self._reading is None or not self._machine.busy_with(commands.JOB):
            return
        view = self.line.piece
        try:
            for _ in range(_CHECKED):
                if not self._reading.readinto(view):
                    self._read_back(0)
                    return
        except Damaged as damaged:
            self._read_back(damaged.args[0])

    def _read_back(self, error):
        """The upload has been read to its end, or is not right."""
        machine = self._machine
        self._store.close(self._reading)
        self._reading = None
        if not error:
            machine.port.feed_watchdog()
            try:
                self._store.keep()
            except OSError:
                error = errors.JOB_SPACE
        if error:
            self._store.abort()
            command = machine.command
            machine.command = None
            machine.note(error, command.link.name if command.link else "")
            machine.tell(Event(commands.REFUSED, command, error))
        else:
            machine.finish()

    def poll_end(self, still):
        machine = self._machine
        if self._file is None or self._proving or not still or machine.dropping or machine.command is not None or machine.drawing or machine.active:
            return
        if self._rest is not None:
            self._read_rest()
        elif self._failed:
            machine.inform(OFF)
            self._end(self._failed)
            if self._failed == errors.JOB_DAMAGED:
                machine.raise_alarm(errors.ALARM_JOB_CHANGED, self._name)
        elif self.line.done():
            self._announce(0)
            self._end(0)

    def heed(self, _):
        """All work is dropped, by a stop, a reset, an alarm."""
        self._close_rest()
        if self._reading is not None:
            self._store.close(self._reading)
            self._reading = None
            self._store.abort()
        if self._file is not None and not self._failed:
            command = self._machine.command
            if command is not None and command.link is not None and command.link.name == LINK:  # its line will have no answer
                self.line.answered += 1
            self._end(errors.JOB_STOPPED)

    def _end(self, error):
        machine = self._machine
        if self._proving:
            self._proving = False
            self._store.close(self._file)
        self.line.end()
        self._file = None
        machine.commander = machine.lender
        machine.lender = -1
        self._ended = self._name, error, self.line.answered
        machine.notice(errors.NOTICE_JOB_ENDED, self._ended)
