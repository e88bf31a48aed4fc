"""`passo check FOLDER`: all programs of a folder, by several processes or a cluster, as one table."""

import contextlib
import os
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple, Optional

from host_tools import language, workers
from host_tools.failure import Failure, reason
from host_tools.language import _, count_text

SUFFIXES = (".nc", ".gcode", ".ngc", ".tap", ".cnc", ".num")
_COLUMNS = ("file", "seconds", "words", "low", "high", "fault")


class Sent(NamedTuple):
    """A file: `data` travels with it to another computer; None: it lies there."""

    path: str
    data: Optional[bytes] = None

    @classmethod
    def from_path(cls, path, travels):
        """Return the file at `path`, with its bytes if it `travels` to another computer. Raises Failure if it cannot be read."""
        try:
            return cls(str(path), Path(path).read_bytes() if travels else None)
        except OSError as error:
            raise Failure("cannot read {}: {}", path, reason(error)) from error

    @contextlib.contextmanager
    def local_path(self):
        """Give the file's path on this computer; bytes that came with it are written to a folder that ends with the block."""
        if self.data is None:
            yield Path(self.path)
            return
        with tempfile.TemporaryDirectory(prefix="passo-") as folder:
            path = Path(folder) / Path(self.path).name
            path.write_bytes(self.data)
            yield path


class Item(NamedTuple):
    """A program, and all that a worker needs to know: `place`: changes, zero and start of a VirtualJob."""

    program: Sent
    board: str | Sent
    tools: Optional[Sent]
    dialect: Optional[str]
    place: tuple
    lang: str


class Row(NamedTuple):
    """The result of one program. `low`, `high`: mm of each axis; `fault`: its first error, "" if it has none."""

    seconds: float
    words: int
    low: tuple
    high: tuple
    fault: str


def check_item(item):
    """Run the program of an Item on a virtual board; return its Row. A worker process calls it."""
    from host_tools import boards
    from host_tools.programs import compiler
    from host_tools.sim.job import VirtualJob

    language.choose_language(item.lang)
    with contextlib.ExitStack() as stack:
        file, tools, board = (each and stack.enter_context(each.local_path()) for each in (item.program, item.tools, _file_of_board(item.board)))
        try:
            program = compiler.read(file, item.dialect, tools, not boards.load(str(board or item.board)).get("rotary"))
            job = VirtualJob(str(board or item.board), *item.place, drawn=False)
            job.origin = program.origin
            job.run(program.rows())
        except Failure as failure:
            return Row(0.0, 0, (), (), failure.message())
        return Row(job.seconds, job.track.steps, tuple(map(float, job.low)), tuple(map(float, job.high)), _fault_text(job, program))


def _fault_text(job, program):
    """Return the first error of a program that has been run, or the travel that it exceeds; "" if it has no fault."""
    if job.errors:
        number, text, what = job.errors[0]
        more = "; " + _("{} in all", count_text(job.error_count, "line")) if job.error_count > 1 else ""
        advice = program.advice()
        return f"{program.origin(number)}: {text}: {what}{more}" + (f"; {advice}" if advice else "")
    too_long = job.beyond_travel()
    return _("larger than the machine: {}", too_long) if too_long else ""


def _file_of_board(board):
    """Return the Sent of a board file; None for one of Passo's own, which is a name."""
    return board if isinstance(board, Sent) else None


def check_folder(folder, board, place, dialect, tools, out, count, cluster):
    """Check the programs of `folder` and print their table; `out`: a .csv of it, or None; `count`: processes, None: as many as there are
    processors; `cluster`: a Dask scheduler's address, or None. Raises Failure, also if one has a fault."""
    files = sorted(path for path in folder.rglob("*") if path.suffix.lower() in SUFFIXES and path.is_file())
    if not files:
        raise Failure("no program in {}: names end in {}", folder, ", ".join(SUFFIXES))
    travels = bool(cluster)
    if board.endswith(".py"):
        board = Sent.from_path(Path(board).expanduser(), travels)
    table = tools and Sent.from_path(tools, travels)
    items = (Item(Sent.from_path(path, travels), board, table, dialect, place, language.current_language()) for path in files)
    begun = time.monotonic()
    found = workers.run_items(check_item, items, min(count or os.cpu_count() or 1, len(files)), cluster)
    width = min(max(len(_relative_name(folder, path)) for path in files), 60)
    faults = 0
    with workers.open_table(out, _COLUMNS) as write:
        for path, row in _in_order([str(path) for path in files], found):
            name = _relative_name(folder, path)
            faults += bool(row.fault)
            print(f"{name:{width}}  {_row_text(row)}", flush=True)
            write((name, f"{row.seconds:.3f}", row.words, *(" ".join(f"{mm:.3f}" for mm in side) for side in (row.low, row.high)), row.fault))
    print(_("{} in {:.1f} s, {} with a fault", count_text(len(files), "program"), time.monotonic() - begun, faults))
    if faults:
        raise Failure("{}: faults in {} of {}", folder, faults, count_text(len(files), "program"))


def _relative_name(folder, path):
    """Return the path of a program below `folder`, as the table shows it."""
    return str(Path(path).relative_to(folder))


def _in_order(paths, found):
    """Yield (path, Row) in the order of `paths`, each as soon as all before it are done; at a terminal show how many are checked."""
    waiting, at, done = {}, 0, 0
    shown = sys.stderr.isatty()
    for item, row in found:
        done += 1
        waiting[item.program.path] = Row(0.0, 0, (), (), _("its worker died {} times", workers.TRIES)) if row == workers.DIED else row
        if shown:
            print("\r\033[K", end="", file=sys.stderr, flush=True)
        while at < len(paths) and paths[at] in waiting:
            yield paths[at], waiting.pop(paths[at])
            at += 1
        if shown and at < len(paths):
            print(_("{} of {} checked", done, len(paths)), end="", file=sys.stderr, flush=True)


def _row_text(row):
    """Return a row of the table behind its name: the fault, or time and size in mm."""
    from host_tools.programs.gcode_file import clock_text

    if row.fault:
        return _("fault: {}", row.fault)
    sides = " x ".join(f"{high - low:.1f}" for low, high in zip(row.low, row.high))
    return f"{clock_text(row.seconds):>8}  {sides} mm"


