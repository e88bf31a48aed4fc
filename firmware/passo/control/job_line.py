"""The serial line of a stored job: reads its file, and counts what is answered.

    line = JobLine()
    line.join(protocol, stored, look, damaged)      # once
    line.begin(job, store)                          # of each job; then it is read as any line

No more is read than the language may have unanswered.
"""

from micropython import const

from passo import errors
from passo.config.job_store import Damaged
from passo.memory import buffer

_PIECE = const(512)  # bytes that are read at once while a job is proven


class JobLine:
    def __init__(self):
        self._most = 0  # units that may be unanswered: lines, packets, codes
        self._first = self._last = b""  # what is still to be given before the file, and behind it
        self.view = self.piece = None  # on the bytes read last; and what a job is proven with
        self._stored = None  # the language's module: how its answers are counted
        self._protocol = None
        self._file = self._store = None
        self._look = None  # called when something has been answered
        self._damaged = None  # called if the file is damaged, with the number of the error
        self.given = self.answered = 0  # units

    def join(self, protocol, stored, look, damaged):
        self._protocol = protocol
        self._stored = stored
        self._most, piece = stored.LIMITS
        self.piece = memoryview(buffer(max(piece, _PIECE)))
        self.view = self.piece[:piece]
        self._look = look
        self._damaged = damaged

    def begin(self, file, store):
        self._file = file
        self._store = store
        self.given = self.answered = 0
        self._first, self._last = self._stored.FRAME
        getattr(self._protocol, "begin_file", int)()

    def leave(self):
        """Give nothing more of the file. Returns it, or None if there is none."""
        file = self._file
        self._file = None
        return file

    def end(self):
        """Give nothing more of the file, and close it."""
        file = self.leave()
        if file is not None:
            self._store.close(file)

    def any(self):
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
                count = self._file.readinto(self.view)
            except Damaged as damaged:
                self._damaged(damaged.args[0])
                return b""
            if self._file.done == self._file.size and not self._file.whole():
                self._damaged(errors.JOB_DAMAGED)
                return b""
            data = self.view[:count]
        self.given += self._stored.units(data)
        return data

    def write(self, data):
        if self._file is not None:
            self.answered = self._stored.answers(bytes(data), self.answered, self.given)
            self._look()

    def done(self):
        """True if all of the file has been given and answered."""
        file = self._file
        return file.done == file.size and not self._last and self.given == self.answered
