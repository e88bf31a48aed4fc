"""`passo stream`: sends a G-code file to a controller that speaks grbl."""

import bisect
import collections
import contextlib
import os
import select
import sys
import time
from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools.cli.lead_in import announce_program, prepare_start
from host_tools.cli.options import Baud, DropZ, Port, ZPen
from host_tools.clients.grbl import LinkError
from host_tools.clients.refusal import Refused
from host_tools.failure import Failure
from host_tools.language import _, count_text, line_text
from host_tools.programs.gcode_time import Remaining
from host_tools.programs.program_lines import changes_settings
from passo import errors

_STATUS_S = 0.25
_RATE_REPORTS = 10  # over which lines a second are counted
_STARVES = 0.1  # part of the queue: with less the machine slows down
_WORTH_S = 5  # a shorter job's lines a second are not printed
_KEEP_S = 1.0
_MOST_SETTINGS = 10  # lines that are shown
FirstLine = Annotated[
    Optional[int], typer.Option("--from", min=1, metavar="LINE", help="Begin at this line of the file, or of a compiled listing.")
]
AllowSettings = Annotated[bool, typer.Option("--allow-settings", help="Do not ask before lines that change settings, startup lines or who commands.")]
Yes = Annotated[bool, typer.Option("--yes", help="With --from: do not ask before the tool goes down.")]


def stream(
    file: Path = typer.Argument(..., help="The G-code."),
    port: Port = None,
    baud: Baud = 115200,
    flow: str = typer.Option("count", help="count: keep the receive buffer full; ok: one line at a time."),
    home: bool = typer.Option(False, help="Home the machine first."),
    unlock: bool = typer.Option(False, help="Leave an alarm without homing first."),
    log: Optional[Path] = typer.Option(None, help="Save the conversation on the wire to this file."),
    timeout: float = typer.Option(5.0, min=0.1, help="Seconds an answer may take."),
    dialect: Annotated[Optional[str], typer.Option(help="num, ngc, or plain: as it is; default: by what stands in the file.")] = None,
    tools: Annotated[Optional[Path], typer.Option(help="The tool table of a program that is compiled; see passo compile.")] = None,
    drop_z: DropZ = False,
    z_pen: ZPen = None,
    first: FirstLine = None,
    yes: Yes = False,
    allow_settings: AllowSettings = False,
):
    """Send a G-code file and show progress. Stops at the first error and names its line.

    It shows the line that moves the machine: lines get their numbers in the file as N words, in place of N words of the
    file's own.

    A program in a dialect of its own, with parameters, subprograms or radius compensation, is compiled first (passo compile); errors
    and progress name the program's lines.

    With --from the lines before are replayed, nothing moves: the tool goes up, over the place where that line begins, spindle and
    coolant go on, and you are asked before the tool goes down. The machine has to know its zero.

    The program ends at M2, M30 or a closing %. Lines that change the machine for good ($20=0, $N0=…, $RST, $LINK) are sent if you agree.

    Keys: p pause, r resume (also after M0, M1 and M6), a abort (also Ctrl-C). An abort first comes to a stand on the path.

    Examples:

        passo stream part.gcode --home
        passo stream part.gcode --port /dev/ttyACM0 --flow ok --log wire.log
        passo stream pocket.ngc --tools tools.tbl --home
        passo stream part.gcode --from 1200 --home
        passo stream settings.nc --allow-settings
    """
    from host_tools.cli import ports
    from host_tools.clients.grbl import GrblClient
    from host_tools.programs import compiler, flat, gcode_file

    if flow not in ("count", "ok"):
        raise Failure("--flow is count or ok, not {!r}", flow)
    program = compiler.read(file, dialect, tools)
    flat.leave_out_z(program, drop_z, z_pen)
    lines = list(program.rows())
    compiler.print_notes(program)
    if not allow_settings:
        ask_settings(lines, program.origin)
    with GrblClient(port or ports.only_port(), baud, timeout, log) as client:
        flat.refuse_z(program, program.flat and any(line.startswith("$102=") for line in client.command("$$")))
        make_ready(client, home, unlock)
        fitted = compiler.fit_to_machine(program, client.command("$I") if program.listing else (), tools)
        if fitted is not program:
            program, lines = fitted, list(fitted.rows())
        seconds, count = _send_program(client, program, lines, flow == "count", first, yes)
        print(_("{}: {} in {}", file, count_text(count, "line"), gcode_file.clock_text(seconds)))


def _send_program(client, program, lines, count, first, yes):
    """Send a program as send() does. If a line is refused, print what to choose in the program that made the file."""
    try:
        return send(client, lines, program.name, count, first, yes, program.origin)
    except Refused:
        if client.alarm is None and (advice := program.advice()):
            print(f"{program.name}: {advice}", file=sys.stderr)
        raise


def ask_settings(lines, origin=line_text):
    """Ask the operator if lines change the machine for good ($20=0, $N0=…). Raises Failure if the answer is no, or there is no terminal."""
    found = [(number, line) for number, line in lines if changes_settings(line)]
    if not found:
        return
    number, line = found[0]
    shown = line.decode("ascii", "backslashreplace")
    if not sys.stdin.isatty():
        raise Failure("{}, {}: it changes the machine for good, and nobody can be asked; --allow-settings sends it", origin(number), shown)
    for number, line in found[:_MOST_SETTINGS]:
        print(f"{origin(number)}: {line.decode('ascii', 'backslashreplace')}")
    print(_("The file changes the machine for good by {}. Send it? [y/N]", count_text(len(found), "line")), end=" ", flush=True)
    if sys.stdin.readline().strip().lower() not in _("y, yes").split(", "):
        raise Failure("not sent: {}, {} changes the machine for good", origin(found[0][0]), shown)


def send(client, lines, name, count, first, yes, origin, keep=None):
    """Send [(number, bytes)] of the program `name` with progress and keys, from line `first` on, if not None. `count`: keep the receive buffer full,
    else one line at a time. Calls `keep(number)` as a line begins to move the machine, once a second. Returns (seconds, lines sent).
    Raises Failure."""
    from host_tools.programs import gcode_time

    if first:
        lines = prepare_start(client, lines, first, None, yes)
    announce_program(client, lines, name)
    zero = next((line for line in client.command("$#") if line.startswith("[G54:")), "[G54:?]")
    limits = gcode_time.Limits.of_settings(client.command("$$"))
    with Panel(client, lines, gcode_time.estimate_seconds(lines, limits), origin, keep) as panel:
        try:
            for number in client.stream(lines, count, panel.poll_keys, True, origin):
                panel.count_line(number)
            client.wait_idle(panel.poll_keys)
        except Refused as refused:
            if client.alarm != errors.ALARM_SOFT_LIMIT - 200:
                raise
            raise Refused(
                "{}\nWork zero G54 lies at {} of the machine; the page, or G10 L20 P1 X0 Y0 Z0 with the tool there, sets it at the workpiece",
                refused, zero[5:-1], number=refused.number,
            ) from None  # fmt: skip
    panel.print_rate()
    return panel.moving_s(), len(lines)


def make_ready(client, home, unlock):
    """Connect; leave an alarm by homing, or by $X if `unlock`. Raises Failure if the machine is in alarm still."""
    client.connect()
    with contextlib.suppress(Refused):
        client.command("$I")  # how many bytes may be under way
    if home:
        _home_or_abort(client)
    elif unlock:
        client.command("$X")
    if client.ask_status()["state"] == "Alarm":
        raise Failure("the machine is in alarm; give --home or --unlock")


def _home_or_abort(client):
    """Home the machine, up to ten minutes. On Ctrl-C reset it and raise Aborted."""
    try:
        client.command("$H", 600)
    except KeyboardInterrupt:
        client.reset()
        raise Aborted("aborted while homing") from None


class Aborted(Failure):
    """The operator ended the job."""


class Panel:
    """The progress bar and the keys. `seconds`: estimated time of each line; `origin(number)`: the name of a line; `keep(number)` is
    called once a second, and at the end, with the line that moves the machine."""

    def __init__(self, client, lines, seconds=None, origin=line_text, keep=None):
        """Begin to count the job's time. `lines`: [(number, bytes)] to be sent."""
        self._keep = keep
        self._kept = 0.0
        self._client = client
        self._origin = origin
        self._remaining = Remaining(seconds or [1.0] * len(lines))
        self._bar = None
        self._numbers = [number for number, _ in lines]
        self._done = 0
        self._line = 0
        self._begun = time.monotonic()
        self._answered = collections.deque([(self._begun, 0)], _RATE_REPORTS)  # (time, lines done)
        self._low = True  # the board's queue is nearly empty
        self._starved = []  # lines at which it became so, though there were more
        self._paused_s = 0.0
        self._paused_at = None
        self._asked = 0.0
        self._keys = contextlib.ExitStack()
        self._asks = True  # for the status; else the board tells it unasked
        self._waits = 0  # 1: told that the machine waits, 2: and a key has come
        self._typed = b""  # lines of a pipe; None: it has ended

    def __enter__(self):
        self._asks = not self._client.report(int(1000 * _STATUS_S))
        if sys.stdin.isatty():
            import termios
            import tty

            before = termios.tcgetattr(sys.stdin)
            self._keys.callback(termios.tcsetattr, sys.stdin, termios.TCSADRAIN, before)
            tty.setcbreak(sys.stdin)
        if sys.stderr.isatty():
            self._bar = self._keys.enter_context(progress_bar())
        return self

    def __exit__(self, kind, *_):
        if self._bar:
            self._show_progress()
        self._keys.close()
        if self._keep and self._line:
            self._keep(self._line)
        if not self._asks and (kind is None or not issubclass(kind, LinkError)):
            self._client.report(0)
        if kind is KeyboardInterrupt:
            self._client.halt()
            raise Aborted("aborted at {}", self._origin(self._line)) from None

    def moving_s(self):
        """Return the seconds that the job has been moving, without its pauses."""
        now = time.monotonic() if self._paused_at is None else self._paused_at
        return now - self._begun - self._paused_s

    def count_line(self, number):
        """Count a line as answered. client.stream() names it by its `number`."""
        self._done += 1

    def poll_keys(self):
        """Handle a key; ask for the status and redraw four times a second. Raises Aborted after a, LinkError if the board is silent."""
        if sys.stdin.isatty() and select.select([sys.stdin], [], [], 0)[0]:
            self.press_key(os.read(sys.stdin.fileno(), 1).decode("ascii", "replace"))
        self._line = max(self._line, int(self._client.status.get("Ln", 0)))
        now = time.monotonic()
        if self._keep and self._line and now - self._kept >= _KEEP_S:
            self._kept = now
            self._keep(self._line)
        self._note_pause(self._client.status.get("state", "").startswith(("Hold", "Door")), now)
        if self._paused_at is not None and "Ln" not in self._client.status:  # at a stand: the line that waits
            # As the report came: behind a key, lines are answered before the next report says that the stand is over.
            self._line = max(self._line, self._numbers[min(self._client.answered_then, len(self._numbers) - 1)])
        self._take_pipe_keys()
        if self._asked and self._client.is_silent():
            raise LinkError("port {}: no answer any more, at {}", self._client.port, self._origin(self._line))
        if now - self._asked >= _STATUS_S:
            self._asked = now
            self._answered.append((now, self._done))
            self._look_at_queue()
            if self._asks:
                self._client.real_time(b"?")
            if self._bar:
                self._show_progress()

    def _look_at_queue(self):
        """Note the line at which the board's queue gets nearly empty, though there are more lines."""
        full, status = self._client.full, self._client.status
        if full is None:
            return
        before, self._low = self._low, full < _STARVES
        if self._low and not before and self._done < len(self._numbers) and status.get("state") == "Run":
            self._starved.append(self._line)

    def print_rate(self):
        """Print lines a second, and how often the machine waited for the link."""
        seconds = self.moving_s()
        if seconds < _WORTH_S or not self._done:
            return
        print(_("{:.0f} lines a second", self._done / seconds))
        if self._starved:
            print(_("the board's queue was nearly empty {} times, first at {}: the machine slowed down to the link's pace", len(self._starved),
                    self._origin(self._starved[0])))  # fmt: skip

    def lines_per_s(self):
        """Return lines a second, over the last _RATE_REPORTS reports."""
        (begun, before), (now, done) = self._answered[0], self._answered[-1]
        return (done - before) / (now - begun) if now > begun else 0.0

    def _note_pause(self, paused, now):
        """Keep a hold, by a key, the door, or M0 in the program, out of the job's time. `now`: s, monotonic."""
        if paused and self._paused_at is None:
            self._paused_at = now
        elif not paused and self._paused_at is not None:
            self._paused_s += now - self._paused_at
            self._paused_at = None

    def _take_pipe_keys(self):
        """If there is no terminal, print once that the machine waits, as for the next pen, and take keys from a pipe, one a line."""
        if self._paused_at is None:
            self._waits = 0
        if self._paused_at is None or self._waits == 2 or not self._client.status["state"].endswith(":0"):
            return
        keys = sys.stdin.isatty()
        if not self._waits and not (keys and self._bar):
            text = _("{}: the machine waits; r goes on, a ends") if keys else _("{}: the machine waits; Enter goes on, a and Enter end")
            print(text.format(self._origin(self._line)), flush=True)
        self._waits = 1
        if not keys and self._typed is not None and (line := self._line_of_pipe()) is not None:
            self._waits = 2
            self.press_key(line.strip()[:1] or "r")

    def _line_of_pipe(self):
        """Return the next line of stdin without waiting, or None."""
        try:
            if b"\n" not in self._typed and select.select([sys.stdin], [], [], 0)[0]:
                more = os.read(sys.stdin.fileno(), 4096)
                self._typed = self._typed + more if more else None
        except (OSError, ValueError):  # no stdin
            self._typed = None
        if self._typed is None:
            print(_("nobody can press a key here: the machine's button or the page goes on"), flush=True)
            return None
        line, found, rest = self._typed.partition(b"\n")
        if not found:
            return None
        self._typed = rest
        return line.decode("ascii", "replace")

    def press_key(self, key):
        """Pause (p), resume (r) or abort (a). Raises Aborted."""
        if key == "p":
            self._client.real_time(b"!")
        elif key == "r":
            self._client.real_time(b"~")
        elif key == "a":
            self._client.halt()
            raise Aborted("aborted at {}", self._origin(self._line))

    def _show_progress(self):
        """Redraw the bar and its text."""
        text = self.progress_text()
        self._bar.update(self._bar.task_ids[0], completed=self._remaining.share, description=text, refresh=True)

    def progress_text(self):
        """Return the line beside the bar: share, line, state, position, link's rate, time gone and left, keys."""
        from host_tools.programs.gcode_file import clock_text

        status = self._client.status
        done = bisect.bisect_left(self._numbers, self._line)
        gone = self.moving_s()
        left = clock_text(self._remaining.seconds_left(done, gone))
        place = status.get("MPos") or status.get("WPos") or ""
        keys = _("PAUSED: r resumes, a aborts") if self._paused_at is not None else _("p pause, a abort")
        times = _("{} gone, {} left", clock_text(gone), left)
        full = self._client.full
        link = _("{:.0f} lines/s", self.lines_per_s()) + ("" if full is None else ", " + _("queue {:.0%}", full))
        return f"{self._remaining.share:4.0%} {self._origin(self._line)}  {status.get('state', '')} {place}  {link}  {times}  ({keys})"


def progress_bar(transient=False):
    """Return a bar on stderr with a text beside it; it has one task, from 0 to 1."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn

    bar = Progress(
        BarColumn(bar_width=24), TextColumn("{task.description}", markup=False), console=Console(stderr=True),
        auto_refresh=False, transient=transient,
    )  # fmt: skip
    bar.add_task("", total=1)
    return bar
