"""bCNC's sender without its window, told what to do in lines of Python on stdin: `sender`, `CNC` and `run(FILE)` are known.

Each line is answered by a line that begins with "= ": its value's repr, or the error. bCNC's own prints go to stderr.
"""

import builtins
import contextlib
import importlib.util
import sys
from pathlib import Path

ROOT = Path(importlib.util.find_spec("bCNC").submodule_search_locations[0])
for folder in ("lib", "plugins", "controllers", ""):
    sys.path.insert(0, str(ROOT / folder))
builtins._ = builtins.N_ = lambda text: text
answers = sys.stdout
sys.stdout = sys.stderr

import Utils  # noqa: E402

Utils.loadConfiguration(systemOnly=True)

from CNC import CNC, WAIT  # noqa: E402
from Sender import Sender  # noqa: E402


class Headless(Sender):
    """Sender is half of bCNC's window: here is what it wants of the other half."""

    def _nothing(self, *_, **__):
        pass

    event_generate = disable = enable = busy = notBusy = _nothing


def run(path):
    """As the window's Run button: the file's lines to the queue of the sending thread."""
    sender.load(path)
    sender.initRun()
    sender._runLines = sys.maxsize
    sender._gcount = 0
    paths = sender.gcode.compile(sender.queue, lambda: False)
    sender._runLines = len(paths) + 1
    sender.queue.put((WAIT,))


def ended():
    """As the window's monitor: the run ends when every line has been answered and the machine stands."""
    if sender.running and sender._gcount >= sender._runLines:
        sender.runEnded()
    return not sender.running


def shown():
    """Return the lines that came into the window's terminal since the last call."""
    lines = []
    while not sender.log.empty():
        lines.append(sender.log.get_nowait()[1])
    return lines


sender = Headless()
for line in sys.stdin:
    try:
        try:
            value = eval(line)
        except SyntaxError:
            value = exec(line)
    except Exception as error:
        value = error
    with contextlib.suppress(BrokenPipeError):
        print("=", repr(value), file=answers, flush=True)
sender.close()
