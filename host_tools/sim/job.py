"""Runs a job of G-code on the virtual port as fast as it can, without a model of the machine, and says what it would do.

    job = VirtualJob("router_3axis")
    job.run([(1, b"G21"), (2, b"G1X10F600")])
    job.seconds, job.low, job.high, job.errors

It starts at machine zero, unlocked, soft limits off: the position of the job's box on a machine is unknown. With `zero`, the position of the
program's zero on the homed machine, soft limits are on. With `start`, the position of the homed machine, they are as in `changes`.
Pauses for the operator are noted in `pauses` and resumed at once; their time counts for nothing. A probe touches nothing: probing moves go their
whole way, and are noted in `probes`. $ lines other than settings and jogs are no part of a job: they are noted in `skipped`. Guards of a real
machine (encoders, interlock, changeover) are left out.

The firmware runs under MicroPython, in a process of its own, if there is one (pip install 'passo[check]'): its machine code
makes words some five times faster than Python. Without it kernels run as C, if there is a compiler (host_tools/build/pc_kernels.py). The
words are the same.
"""

import ast
import itertools
import re
import struct
import subprocess
import threading

import numpy as np

from host_tools import boards, interpreter, language
from host_tools.build.pc_kernels import use_compiled
from host_tools.clients.refusal import error_meaning
from host_tools.failure import Failure, reason
from host_tools.language import _, error_text
from host_tools.sim import job_runner
from host_tools.sim.parts import is_endless
from host_tools.sim.track import Track
from passo import errors

BLOCK_LINES = 256
MOST_NOTES = 1000  # of a kind, that are kept


def strip_guards(board):
    """Return a board file's dict without the keys that guard a real machine."""
    kept = {key: value for key, value in board.items() if key not in ("drivers", "encoders", "interlock", "inverter", "spi_drivers")}
    if "inputs" in board:
        kept["inputs"] = [{key: value for key, value in item.items() if key != "filter_us"} for item in board["inputs"]]
    if "outputs" in board:
        kept["outputs"] = [item for item in board["outputs"] if item.get("role", "none") == "none"]
    return kept


def due_of_array(words, mask, bits, first, count, ticks, store, at, box):
    """Do the work of job_runner.copy_due() under CPython, with numpy."""
    ring = np.frombuffer(words, np.uint32)
    found = ring[first : first + count]
    if first + count > mask + 1:
        found = np.concatenate([found, ring[: first + count - mask - 1]])
    ends = np.cumsum(found >> bits, dtype=np.int64)
    done = min(int(np.searchsorted(ends, ticks)) + 1, count)
    np.frombuffer(store, np.uint32)[at : at + done] = found[:done]
    box[0] = int(ends[done - 1])
    return done


def _job_blocks(lines):
    """Yield the lines of a job in blocks, as job_runner.py reads them; an empty one ends them."""
    lines = iter(lines)
    while True:
        block = b"\n".join(b"%d\t%s" % row for row in itertools.islice(lines, BLOCK_LINES))
        yield block
        if not block:
            return


class VirtualJob:
    def __init__(self, board, changes=(), zero=None, start=None, drawn=True, inside=False):
        """`board`: a name or a path; `changes`: lines carried out first, as text; `zero`: mm from machine zero, a figure an axis; `start`: the same
        of where the machine stands; `drawn`: False keeps no path; `inside`: the firmware runs in this process. Raises Failure if the board file
        cannot be used, or `zero` is not on the machine."""
        from passo.config.boardfile import BoardError, check
        from passo.machine_builder import make_drive

        self._setup = strip_guards(boards.load(board)), list(changes), zero, start
        try:
            self.board = check(strip_guards(boards.load(board)))
        except BoardError as error:
            raise Failure("{}", reason(error)) from error
        layout, drive, _ = make_drive(self.board)
        if layout.kind == "step_dir":
            drive = None
        self.steps_per_mm = [axis["steps_per_m"] / 1000 for axis in self.board["axes"]]
        by_height = len(self.steps_per_mm) > 2 and not self.board["spindle"]["laser"]
        self.track = Track(layout, drive, self.steps_per_mm, by_height, drawn, self.board.get("kinematics") == "corexy")
        self.placed = zero is not None or start is not None
        if zero is not None and len(zero) > 2:
            self.track.surface = zero[2]
        self.errors = []  # (line of the file, its text, what was wrong)
        self.error_count = 0
        self.pauses = []  # (line of the file, its text)
        self.probes = []  # the same
        self.skipped = []
        self.origin = language.line_text  # origin(number): the name of a line in a failure
        self.seconds = 0.0
        self._progress = None
        self._runner = None
        self._process = None
        command = None if inside else interpreter.micropython_command()
        if command:
            self._start_process(command)
        else:
            self._in_process()

    def run(self, lines, progress=None):
        """Execute [(number, bytes)] to the end of their motion. Calls `progress(number)` now and then. Raises Failure."""
        self._progress = progress
        try:
            if self._process:
                self._run_process(lines)
            else:
                self._runner.run(lines)
        except job_runner.Failed as failed:
            raise self._failure_of(failed.line, failed.said) from failed
        self.seconds = self.track.seconds

    # --- what the runner says

    def add_words(self, number, tick, words):
        self.track.add_words(tick, np.array(words, np.uint32))
        if self._progress:
            self._progress(number)

    def begin(self, tick, place):
        self.track.begin(tick, place)

    def add_note(self, kind, number, code, text):
        """Add a note to the errors, pauses, probes or skipped lines of the job, at most MOST_NOTES each; errors are also counted."""
        text = text.decode()
        if kind in (job_runner.NOTE_REFUSED, job_runner.NOTE_ALARM):
            self.error_count += 1
            refused = kind == job_runner.NOTE_REFUSED
            what = _("error {}, {}", code, error_meaning(code, text.encode())) if refused else _("alarm {}, {}", code - 200, error_text(code))
            if code == errors.UNSUPPORTED and (missing := self._missing_axis(text)):
                what = _("{} (this machine has no axis {})", what, missing) if missing != "Z" else _("{} (this machine has no Z: --drop-z, --z-pen)", what)
            found, row = self.errors, (number, text, what)
        else:
            kinds = {job_runner.NOTE_PAUSED: self.pauses, job_runner.NOTE_PROBED: self.probes, job_runner.NOTE_SKIPPED: self.skipped}
            found, row = kinds[kind], (number, text)
        if len(found) < MOST_NOTES:
            found.append(row)

    def _missing_axis(self, line):
        """Return the first axis that `line` names and the machine has not, or None."""
        names = [axis["name"].upper() for axis in self.board["axes"]]
        return next((name for name in re.findall("([XYZA])[-+.0-9]", line) if name not in names), None)

    # --- the firmware in this process

    def _in_process(self):
        """Build the runner in this process, with compiled kernels. Raises Failure if the start fails."""
        use_compiled()
        try:
            self._runner = job_runner.Runner(self._setup[0], self, due_of_array, *self._setup[1:])
        except job_runner.Failed as failed:
            raise self._failure_of(failed.line, failed.said) from failed

    # --- the firmware under MicroPython

    def _start_process(self, command):
        """Start the runner in MicroPython (`command`), give it the setup, and wait until it begins. Ends it again at any error."""
        from host_tools.build.unix_compiled import firmware_for

        folder, arguments = firmware_for(tuple(command), job_runner.__file__)
        self._process = subprocess.Popen(
            [*command, "-X", "heapsize=8m", *arguments], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=subprocess.PIPE, env=interpreter.environment(folder), cwd=folder,
        )  # fmt: skip
        self._process.stdin.write(repr(self._setup).encode() + b"\n")
        self._process.stdin.flush()
        try:
            while self._take_frame() != job_runner.BEGIN:
                pass
        except BaseException:
            self._end_process()
            raise

    def _run_process(self, lines):
        """Lines go out by a thread of their own: each side may have to wait for the other."""
        trouble = []

        def send():
            """Send the lines to the process in blocks, each behind its length in bytes; at an error of this side kill the process."""
            try:
                with self._process.stdin as stream:
                    for block in _job_blocks(lines):
                        stream.write(b"%d\n%s" % (len(block), block))
                        stream.flush()
            except BrokenPipeError:
                pass  # it has ended, and said why
            except Exception as error:
                trouble.append(error)
                self._process.kill()

        sender = threading.Thread(target=send, daemon=True)
        sender.start()
        try:
            while self._take_frame() != job_runner.END:
                pass
            sender.join()
        except Failure:
            if not trouble:
                raise
        finally:
            self._end_process()
        if trouble:  # the runner may have finished its input before it was killed
            raise trouble[0]

    def _take_frame(self):
        """Take one frame of the runner; return its kind. Raises Failure."""
        stream = self._process.stdout
        header = stream.read(struct.calcsize(job_runner.HEADER))
        if len(header) < struct.calcsize(job_runner.HEADER):
            said = self._process.stderr.read().decode(errors="replace").strip()
            raise Failure("the firmware under MicroPython has ended: {}", said or "-")
        kind, number, size, value = struct.unpack(job_runner.HEADER, header)
        data = stream.read(size)
        if kind == job_runner.WORDS:
            self.add_words(number, value, np.frombuffer(data, np.uint32))
        elif kind == job_runner.BEGIN:
            self.begin(value, np.frombuffer(data, np.int32).tolist())
        elif kind == job_runner.FAILED:
            raise self._failure_of(number, ast.literal_eval(data.decode()))
        elif kind != job_runner.END:
            self.add_note(kind, number, value, data)
        return kind

    def _failure_of(self, line, said):
        """Return the Failure of a runner's message, which says why a job cannot go on."""
        text, *values = said
        why = Failure(text, *(_(value) if isinstance(value, str) else value for value in values))
        return Failure("{}, {}", self.origin(line), why) if line else why

    def _end_process(self):
        """Kill the process and close its pipes."""
        process = self._process
        process.kill()
        process.wait()
        process.stdout.close()
        process.stderr.close()

    @property
    def low(self):
        """Lowest position of each axis in mm."""
        return self.track.low

    @property
    def high(self):
        """Highest position of each axis, mm."""
        return self.track.high

    def excess_text(self, number):
        """Return a text if the job is longer than the travel of axis `number`, else ""."""
        axis = self.board["axes"][number]
        if is_endless(self.board, axis):
            return ""
        travel = axis["travel_steps"] / self.steps_per_mm[number]
        length = self.high[number] - self.low[number]
        # Travel and position are whole steps, each rounded once.
        if length <= travel + 1 / self.steps_per_mm[number]:
            return ""
        return _("{} goes {:.1f} of {:.1f} mm", axis["name"].upper(), length, travel)

    def beyond_travel(self):
        """Return how the job is longer than the machine's travel, as text; "": it is not."""
        return ", ".join(text for text in map(self.excess_text, range(len(self.steps_per_mm))) if text)
