"""How much of the tests runs: `pytest --tier check|test|all`, which `make check`, `make test` and `make test-all` give.

    check   what is marked `quick`, and FEW examples of each property that NOT_QUICK does not name, under MicroPython nothing else: in 90 s
    test    all but what is marked `slow`, under MicroPython one PARTth of the examples, at most SOME: what guards a commit
    all     everything; also what pytest runs if nobody asks for less

    examples(60, tier="check")      # how many of 60 examples of a property are tried

Coverage is measured in part: a loop of the firmware that runs for the thousandth time is four times slower under its
tracer, and nothing new. So it sees the first MEASURED_S of each test, in processor time, and no test marked `unmeasured`.
"""

import os
import signal
import sys
from contextlib import contextmanager

TIERS = ("check", "test", "all")
FEW = 3
SOME, PART = 8, 8  # CPython has tried all of them
MEASURED_S = 0.05
_OF_PROGRAMS = "COVERAGE_PROCESS_CONFIG"  # has the programs that a test starts measured too
current = "all"


def examples(count, tier=None):
    return min(count, FEW) if (tier or current) == "check" else count


def reads(text, tier):
    """Whether a file of this text has a test that may run."""
    return tier != "check" or "mark.quick" in text


def runs(slow, quick, tier=None):
    """Whether a test with these marks runs."""
    tier = tier or current
    return tier == "all" or not slow and (tier == "test" or quick)


def _stop(*_):
    sys.settrace(None)


@contextmanager
def measuring(wanted):
    """Coverage's tracer, where there is one, sees the first MEASURED_S of what is done here, or nothing of it."""
    tracer = sys.gettrace()
    if tracer is None:
        yield
        return
    before = signal.signal(signal.SIGPROF, _stop)
    of_programs = None if wanted else os.environ.pop(_OF_PROGRAMS, None)
    if wanted:
        signal.setitimer(signal.ITIMER_PROF, MEASURED_S)
    else:
        _stop()
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)
        if of_programs is not None:
            os.environ[_OF_PROGRAMS] = of_programs
        sys.settrace(tracer)
