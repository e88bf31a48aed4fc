"""Draws objects of points on a plotter, from their start or where they were interrupted: progress, signals, the board's journal."""

import contextlib
import functools
import select
import signal
import sys
import time
from typing import NamedTuple

from host_tools.cli.draw_options import continue_advice, pen_of
from host_tools.cli.lead_in import operator_agrees
from host_tools.clients.plotter import POLL_S
from host_tools.clients.refusal import Refused
from host_tools.failure import Failure
from host_tools.language import _
from host_tools.programs import drawing_progress, job_record


BAUD = 57600
_LOOK_S = 0.5


class Way(NamedTuple):
    """How a drawing begins: `resume`: where it was interrupted; `home` first; without that, and the position is not known, only if
    `unverified`; `strict`: only by the board's journal; `ask` before the pen goes down."""

    resume: bool = False
    home: bool = True
    unverified: bool = False
    strict: bool = False
    ask: bool = False


class Plotted:
    """A drawing for a plotter. `seconds`: that it takes, about."""

    def __init__(self, machine, plan, said):
        """Estimate the time of a plan on a plotter. `said`: the command's options."""
        from host_tools.programs import estimate

        self._machine, self._plan, self._said = machine, plan, said
        times = estimate.Estimate(machine, said.speed)
        self.seconds = sum(times.lines_s(part.lines) for part in plan.parts)
        self._changes = plan.part_starts(said.points) if said.pens != "none" else {}
        self._travel_s_per_mm = times.object_s([(False, round(1000 * plan.steps_per_mm[0]), 0)])[0] / 1000

    @functools.cached_property
    def _point_objects(self):
        """Return the drawing as objects of points for the plotter, --points each at most. Made once."""
        return self._plan.objects(self._said.points)

    @property
    def digest(self):
        """Return the hash of all points: the journal beside the drawing has it."""
        return self._plan.digest(self._said.points)

    def tool_lines(self):
        """Yield a line for each pen that the operator has to insert."""
        for part in self._changes.values():
            yield _("pen {}: you are asked for it before it draws", pen_of(part))

    def travel_s(self, length_mm):
        """Return the seconds that a way of `length_mm` takes with the pen up."""
        return length_mm * self._travel_s_per_mm

    def write(self, console, path):
        """Write the packets to a file. Raises Failure if pens have to be changed, or it cannot be written."""
        if self._changes:
            raise Failure("a file of packets cannot wait for a pen's change: write one file for each layer, by --layer")
        drawing_progress.write_packets(path, self._point_objects, self._said.home, self._said.speed)
        console.print(_("  {0}: to be stored by passo jobs store {0} --protocol plotter", path))

    def run(self, console, record, said):
        """Draw on the plotter at --port. Raises Failure, also if it is stopped."""
        if self._said.unlock:
            raise Failure("--unlock is for machines that speak grbl: a plotter seeks its origin, or draws from where it is by --no-home")
        way = Way(said.resume, said.home)
        stored = drawing_progress.numbers_of_stored(self._point_objects, said.speed)
        run(console, self._point_objects, self._machine, record, said.port, said.baud or BAUD, said.speed, way, said.log, said.timeout, stored, self._changes)


def run(console, objects, machine, record, port, baud, speed, way, log=None, timeout=3.0, numbers=(), changes=None):
    """Draw `objects`; `record`: the Journal beside the drawing, or None; `machine`: a checked board file, for the times; `numbers`:
    other numbers by which the board may know the drawing; `changes`: {index of an object: the Part whose pen it wants}. Raises Failure."""
    from host_tools.cli import ports
    from host_tools.clients.plotter import Cancelled, PlotterClient
    from host_tools.clients.serial_port import LinkError
    from host_tools.programs.job import Broken, Job

    begun = time.monotonic()
    with PlotterClient(port or ports.only_port(), baud, timeout, log) as client:
        with _cancel_by_signals(client):
            job = Job(client, objects, record, lambda text: console.print(f"[yellow]{text}[/yellow]"))
            try:
                with console.status(_("homing") if way.home else _("preparing")):
                    _wait_until_at_rest(client, way)
                    spot = _find_spot(client, objects, record, way, numbers)
                    if way.home:
                        client.origin()
                    if speed is not None:
                        client.speed(speed)
                if spot:
                    console.print(_("  interrupted {}", spot))
                    job.begin(spot)
                    drawing_progress.announce_rest(client, objects, spot)
                if way.resume and changes:
                    pens = [part for number, part in changes.items() if number <= (spot.number if spot else record.object)]
                    if pens:
                        console.print(_("  pen {} draws on", pen_of(pens[-1])))
                if not way.resume:
                    drawing_progress.announce_rest(client, objects, drawing_progress.Spot(0, 0))
                if spot and spot.done:
                    _lead_to_spot(client, objects, spot, way)
                with _Progress(console, job, machine, speed) as progress:
                    job.run(progress, lambda number: _wait_for_pen(console, client, progress, (changes or {}).get(number)))
            except Broken as broken:
                raise Failure("{}, pen up; {}", broken, continue_advice(record)) from None
            except Cancelled:
                client.stop()
                raise Failure("stopped before drawing began") from None
            except LinkError as error:
                if not job.begun:
                    raise
                raise Failure(
                    "{}\n{} drawn for certain; when the machine is there again, {}",
                    error, job.progress_text(), continue_advice(record),
                ) from error
        if record:
            record.remove_file()
        took = time.monotonic() - begun
        console.print(_("drawn in {:.0f} s: {} packets, {} sent again", took, client.packets, client.resends))


def _wait_for_pen(console, client, progress, part):
    """Wait until the operator has put in the pen of `part` (None: no change) and pressed Enter. Raises Cancelled on Ctrl-C, or if standard input
    ends."""
    from host_tools.clients.plotter import Cancelled

    if part is None:
        return
    with progress.hide_bar():
        console.print(_("put in pen {}, then press Enter", pen_of(part)))
        while not select.select([sys.stdin], [], [], _LOOK_S)[0]:
            client.status()
        if not sys.stdin.readline():
            raise Cancelled


@contextlib.contextmanager
def _cancel_by_signals(client):
    """Stop the machine on Ctrl-C, SIGTERM and SIGHUP (a closed terminal) within the block."""
    numbers = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
    before = [(number, signal.signal(number, lambda *_: client.cancel())) for number in numbers]
    try:
        yield
    finally:
        for number, handler in before:
            signal.signal(number, handler)


def _wait_until_at_rest(client, way):
    """Wait until the machine is at rest: it draws the points that it has of an interrupted drawing. Raises Failure if it moves and --continue is not
    given."""
    while True:
        status = client.request()
        if status["state"] in ("idle", "alarm"):
            break
        if not way.resume:
            raise Failure("the machine is moving; stop it first: passo send STOP")
        time.sleep(POLL_S)
    client.stop()  # drops points that a program before left unfinished


def _find_spot(client, objects, record, way, numbers):
    """Return the Spot at which the drawing goes on: from the board's journal if it is of this drawing, else from the PC's. None: at the start. Raises
    Failure."""
    if not way.resume:
        return None
    found = None
    try:
        record_of = job_record.Record.of_job if way.strict else job_record.Record.of_answer
        found = record_of(client.ask("$JR"))
    except Refused as refused:
        if way.strict:
            raise Failure("the board has no journal (docs/use/jobs.md): {}; passo draw --continue needs none", refused) from None
    if found and found.job in (drawing_progress.number_of(objects), *numbers):
        spot = drawing_progress.spot_of(found, objects)
        job_record.find_zero(found.is_known, way.home, way.unverified, lambda: None)
        return spot
    if way.strict:
        raise Failure("the board's journal is of another drawing, or it was drawn with other options: give them to passo draw --continue")
    record.resume_from_file()
    return drawing_progress.spot_at(objects, record.object, record.drawn) if found else None


def _lead_to_spot(client, objects, spot, way):
    """Move over the spot with the pen up; with `way.ask` ask the operator. Raises Failure if the operator says no."""
    start = spot.start(objects)
    client.point(False, *start)
    client.end(1)
    if way.ask and not operator_agrees(_("next is point {}, from {}, {} steps", spot.done + 1, *start)):
        raise Failure("not gone on: the pen is up")


class _Progress:
    """A bar that fills with the estimated time, and the time left by the pace kept so far."""

    def __init__(self, console, job, machine, speed):
        """Estimate the time of each object of a Job."""
        from rich.progress import BarColumn, Progress, TextColumn

        from host_tools.programs import estimate

        self._clock = estimate.clock_text
        times = estimate.Estimate(machine, speed)
        self._spans = [times.object_s(points) for points in job.objects]
        self._totals = [sum(span) for span in self._spans]
        self._client = job.client
        self._begun = time.monotonic()
        self._points = sum(len(points) for points in job.objects)
        self._counts = [len(points) for points in job.objects]
        start = job.start
        self._first = self._seconds_done(*start)
        self._bar = Progress(
            TextColumn(_("drawing")),
            BarColumn(),
            TextColumn("{task.percentage:3.0f} %"),
            TextColumn("{task.description}"),
            console=console,
        )
        self._task = self._bar.add_task("", total=max(sum(self._totals), 1e-9))
        self(*start)

    def __enter__(self):
        self._bar.start()
        return self

    def __exit__(self, *_):
        self._bar.stop()

    @contextlib.contextmanager
    def hide_bar(self):
        """Hide the bar within the block."""
        self._bar.stop()
        yield
        self._bar.start()

    def __call__(self, number, drawn):
        done = self._seconds_done(number, drawn)
        left = sum(self._totals) - done
        gained = done - self._first
        if gained > 5:
            left *= (time.monotonic() - self._begun) / gained
        points = sum(self._counts[:number]) + drawn
        text = _("{}/{} points, {} sent again, {} left", points, self._points, self._client.resends, self._clock(left))
        self._bar.update(self._task, completed=done, description=text)

    def _seconds_done(self, number, drawn):
        """Return the estimated seconds of `number` whole objects and `drawn` points of the next one."""
        done = sum(self._totals[:number])
        return done + sum(self._spans[number][:drawn]) if number < len(self._spans) else done
