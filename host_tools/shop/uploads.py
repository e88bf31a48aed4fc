"""A file that is dropped on the shop's page becomes jobs: checked by the firmware on a virtual board of its kind, before it is queued.

    made = job_of("cat.svg", data, "corexy_plotter")    # (name, bytes of G-code, facts). Raises Failure
"""

import re
import tempfile
from pathlib import Path

from host_tools import boards
from host_tools.failure import Failure
from host_tools.language import _, error_text
from host_tools.page.slow_order import is_refusal
from host_tools.panel import drawing_jobs
from host_tools.programs import compiler
from host_tools.sim.job import VirtualJob
from passo.config.boardfile import check

MOST_BYTES = 4 << 20
_NAME = re.compile(r"[^\x00-\x1f/\\]{1,80}")


class _AsItIs:
    settings = {}


def job_of(name, data, kind):
    """Return (name, bytes of G-code, facts) of an uploaded file, checked on a virtual board. `kind`: a board file that speaks grbl and keeps a
    journal. Facts: "seconds", "area" in mm. Raises Failure."""
    if not _NAME.fullmatch(name) or len(data) > MOST_BYTES:
        raise Failure("{}: a name of at most 80 letters is wanted, and a file of at most {} bytes", name, MOST_BYTES)
    board = check(boards.load(kind))
    if board["links"][0]["protocol"] != "grbl" or not board.get("journal"):
        raise Failure("{}: jobs are for boards that speak grbl and have the key journal", kind)
    found = drawing_jobs.gcode_of(board, _AsItIs)(name, data.decode("utf-8", "replace"))
    if is_refusal(found):
        raise Failure("{}: {}", name, error_text(found)) if isinstance(found, int) else Failure("{}", found["text"])
    name, text = found
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "job.gcode"
        path.write_text(text, encoding="utf-8")
        program = compiler.read(path, "plain", None)
        job = VirtualJob(kind, (), None, None)
        job.run(program.rows())
        advice = program.advice()
    if job.errors:
        raise Failure("{}: line {} would be refused: {}", name, job.errors[0][0], job.errors[0][2] + (f"; {advice}" if advice else ""))
    if too_long := job.beyond_travel():
        raise Failure("{} is larger than the machine: {}", name, too_long)
    area = [round(high - low, 2) for low, high in zip(job.low[:2], job.high[:2])]
    return name, text.encode(), {"seconds": round(job.seconds, 1), "area": area}


def list_kinds():
    """The names of the board files that take jobs of the shop: they speak grbl and keep a journal."""
    found = []
    for name in boards.names():
        board = check(boards.load(name))
        if board["links"][0]["protocol"] == "grbl" and board.get("journal"):
            found.append(name)
    return found
