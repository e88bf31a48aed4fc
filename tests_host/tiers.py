"""How much of the tests runs: `pytest --tier check|test|all`, which `make check`, `make test` and `make test-all` give.

    check   what is marked `quick`, and FEW examples of each property that NOT_QUICK does not name, under MicroPython nothing else: in 90 s
    test    all but what is marked `slow`, and half of the examples of each property; under MicroPython one PARTth of them, at most SOME, and
            nothing that NOT_QUICK names: what guards a commit
    all     everything; also what pytest runs if nobody asks for less

    examples(60, tier="check")      # how many of 60 examples of a property are tried

Coverage is measured in part: a loop of the firmware that runs for the thousandth time is four times slower under its
tracer, and nothing new. So it sees the first MEASURED_S of each test and of its fixtures, in processor time, also in their threads,
no test marked `unmeasured`, and programs that a test starts where it is marked `programs_measured`.
"""

import os
import signal
import sys
import threading
from contextlib import contextmanager

TIERS = ("check", "test", "all")
FEW = 3
SOME, PART = 5, 16  # CPython has tried more of them
MEASURED_S = 0.15  # enough for a PC of half the speed to cover 90 %
_OF_PROGRAMS = "COVERAGE_PROCESS_CONFIG"  # has the programs that a test starts measured too
current = "all"


def examples(count, tier=None):
    few = min(count, FEW)
    return {"check": few, "test": max(few, count // 2), "all": count}[tier or current]


def reads(text, tier):
    """Whether a file of this text has a test that may run."""
    return tier != "check" or "mark.quick" in text


def runs(slow, quick, tier=None):
    """Whether a test with these marks runs."""
    tier = tier or current
    return tier == "all" or not slow and (tier == "test" or quick)


class _Threads:
    """The tracers of threads that begin while there is one: coverage installs them, and each can be stopped from here."""

    def __init__(self):
        self._install = threading.gettrace()
        self._tracers = []

    def follow(self):
        threading.settrace(self._begin if self._install else None)

    def _begin(self, frame, event, arg):
        traced = self._install(frame, event, arg)
        self._tracers.append(sys.gettrace())
        return traced

    def stop(self):
        threading.settrace(None)
        for tracer in self._tracers:
            if hasattr(tracer, "stop"):  # of coverage
                tracer.stop()

    def restore(self):
        threading.settrace(self._install)


@contextmanager
def measuring(wanted, programs=False):
    """Let coverage's tracer, if there is one, see the first MEASURED_S of the work here, or none of it; `programs`: the whole of
    those that are started, too."""
    tracer = sys.gettrace()
    if tracer is None:
        yield
        return
    threads = _Threads()

    def stop(*_):
        sys.settrace(None)
        threads.stop()

    before = signal.signal(signal.SIGPROF, stop)
    of_programs = None if wanted and programs else os.environ.pop(_OF_PROGRAMS, None)
    if wanted:
        threads.follow()
        signal.setitimer(signal.ITIMER_PROF, MEASURED_S)
    else:
        stop()
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)
        if of_programs is not None:
            os.environ[_OF_PROGRAMS] = of_programs
        threads.stop()
        threads.restore()
        sys.settrace(tracer)
