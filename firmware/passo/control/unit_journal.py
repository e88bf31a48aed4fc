"""The journal of jobs that are counted, not numbered: the commands of a step program, the points of a drawing.

A job is announced before it comes: JOURNAL with (number, line, flags, lead, place), which become the first record, so that a job that is
gone on with may be interrupted before it has moved. `lead`: commands or points that come first and are none of the job's, such as
the way to the place. What is not announced is not written down.

Flags, besides those of job_journal.py: BACK, a step program is played towards its start; from bit 8 on the times that it is to be
played, this one included.

A step program's line is how many of its commands are done, and the position is that behind the last: a step is made or it is not. A
drawing's line is the point under way. The position is known, as homed, as long as it has been counted since the job began.
"""

from array import array

from micropython import const

from passo.commands import SPOT_AXES, SPOT_BACK, SPOT_PLACE, SPOT_TIMES
from passo.control.job_journal import DONE, HOMED, JobJournal
from passo.records import COUNT_MASK

BACK = const(4)
_TIMES = const(8)  # the bit that they begin at


class UnitJournal(JobJournal):
    def __init__(self, board, machine, queue):
        JobJournal.__init__(self, board, machine, queue)
        self._spot = array("i", [0] * (SPOT_AXES + self._axes))
        self._done = self._lead = self._times = 0  # as announced
        self._back = False

    def _begin(self, job):
        machine = self._machine
        number, line, flags, lead, place = job if isinstance(job, tuple) else (job, 0, DONE, 0, None)
        self._job = number
        self._line = line
        self._flags = flags & ~HOMED
        self._lead = lead
        self._back = bool(flags & BACK)
        self._times = flags >> _TIMES
        self._done = self._least = line if flags & DONE else max(line - 1, 0)
        if place is not None:
            self._position[: len(place)] = place
        job = machine.job
        job.counted = self._done - lead
        job.announced = True
        job.kept = not machine.alarm
        job.counting = False

    def _homed(self):
        return HOMED if self._machine.homed or self._machine.job.kept else 0

    def poll(self, now_ms):
        JobJournal.poll(self, now_ms)
        job = self._machine.job
        if not job.progress or not job.counting or not self._job:
            return
        if not self._queue.still():
            if now_ms - self._written_ms & COUNT_MASK < self._interval():
                return
            self._written_ms = now_ms
        self._walked()

    def halt(self):
        JobJournal.halt(self)
        job = self._machine.job
        if job.progress and job.counting and self._job:
            self._walked()

    def _walked(self):
        """Write down where the step program is."""
        spot = self._spot
        if not self._machine.job.progress(spot):
            return
        count = max(spot[SPOT_PLACE] - self._lead, 0)
        self._line = self._done - count if self._back else self._done + count
        back = self._back != bool(spot[SPOT_BACK])
        self._flags = DONE | self._homed() | (BACK if back else 0) | (self._times or spot[SPOT_TIMES]) << _TIMES
        for axis in range(self._axes):
            self._position[axis] = spot[SPOT_AXES + axis]
        self._write()
