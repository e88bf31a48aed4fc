"""Runs work on a copy of an emulated Pico: loading its firmware takes a minute, forking a few milliseconds.

    steps = on_a_copy(lambda: run_and_count(pico))      # pico stays as it was

The work is done in a forked process and its result comes back pickled. Only where the system can fork.
"""

import os
import pickle
import signal
import sys
import traceback

from host_tools.emulator.cycles import spent


class CopyFailed(Exception):
    """The work raised; the text is its traceback."""


def on_a_copy(work):
    """Call `work()` in a copy of this process; returns its result. Raises CopyFailed if it raises."""
    sys.stdout.flush()
    sys.stderr.flush()
    reading, writing = os.pipe()
    child = os.fork()
    if not child:
        os.close(reading)
        _run_in_child(work, writing)
    os.close(writing)
    try:
        with os.fdopen(reading, "rb") as pipe:
            data = pipe.read()
    except BaseException:  # Ctrl-C, or a test that has taken too long: the copy would go on for ever
        os.kill(child, signal.SIGKILL)
        raise
    finally:
        _, status = os.waitpid(child, 0)
    if not data:
        raise CopyFailed(f"the copy ended without a result, status {status}")
    failed, result, cycles = pickle.loads(data)
    spent[0] += cycles
    if failed:
        raise CopyFailed(result)
    return result


def _run_in_child(work, writing):
    """Do the work, write its pickled result, and end the process. Never returns."""
    begun = spent[0]
    try:
        try:
            result = work()
            data = pickle.dumps((False, result, spent[0] - begun))
        except BaseException:  # also pytest's, which are no Exceptions
            data = pickle.dumps((True, traceback.format_exc(), spent[0] - begun))
        with os.fdopen(writing, "wb") as pipe:
            pipe.write(data)
        sys.stdout.flush()
        sys.stderr.flush()
    finally:
        os._exit(0)
