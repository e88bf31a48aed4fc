"""`python -m host_tools.cli.run`: the main job on the virtual board, by packets through a pty, into `out/`.

For each of the five objects of 2014 and the contour map it starts a virtual board, homes it and draws, measures the trace
against the commanded points, and plots it. Exit status 0 only if every path is exact. Traces leave out the time in which
nothing is under way, so those of two runs are equal: diff shows it.
"""

import signal
import subprocess
import sys
import time
from pathlib import Path

from host_tools import boards, interpreter
from host_tools.clients.plotter import PlotterClient
from host_tools.drawings import contours, drawing, objects, plot
from host_tools.failure import Failure
from host_tools.language import _
from host_tools.programs.job import Job
from host_tools.sim.measure import measure_drawing, read_trace

BOARD = "plotter_2014"
POINTS_PER_OBJECT = 1000
LARGEST_DEVIATION = 0.5  # steps on the minor axis: Bresenham's bound
_START_S = 20


def create_jobs(out):
    """Return {name: list of objects} to draw; write the contour map's SVG to the folder `out`."""
    found = {name: [points] for name, points in objects.objects().items()}
    svg = out / "contours.svg"
    contours.save_contours(svg)
    found["contours"] = drawing.load(svg, boards.load(BOARD), drawing.Options(center=True)).objects(POINTS_PER_OBJECT)
    return found


def draw_job(name, job, trace):
    """Draw one job on a virtual board that writes `trace`. Return the client, closed, for its counts. Raises Failure."""
    command = [*interpreter.passo(), "board", "--board", BOARD, "--time", "fast"]
    process = subprocess.Popen([*command, "--trace", str(trace), "--no-idle"], stdout=subprocess.PIPE, text=True)
    try:
        with PlotterClient(_read_port(process)) as client:
            client.request()
            client.origin()
            client.speed(1000)
            Job(client, job).run()
    finally:
        process.send_signal(signal.SIGTERM)
        try:
            process.wait(10)
        except subprocess.TimeoutExpired:
            process.kill()
            raise Failure("{}: the virtual board did not stop", name) from None
        process.stdout.close()
    if process.returncode:
        raise Failure("{}: the virtual board ended with status {}", name, process.returncode)
    return client


def _read_port(process):
    """Return the pty that the board prints. Raises Failure if it ends without printing one."""
    for line in process.stdout:
        if line.startswith("port: "):
            return line.split(": ", 1)[1].strip()
    raise Failure("the virtual board did not start (status {})", process.wait(_START_S))


def main():
    """Draw all jobs, and print a table with the deviation of each. Raises Failure if a path is not exact."""
    from rich.console import Console
    from rich.table import Table

    out = Path("out")
    out.mkdir(exist_ok=True)
    begun = time.monotonic()
    console = Console()
    heads = (_("points"), _("packets"), _("resends"), _("steps"), _("time s"), _("off line"), _("path"))
    table = Table(_("drawing"), *map(_right_column, heads), title=_("Passo on {}", BOARD))
    scale = boards.steps_per_mm(boards.load(BOARD))
    faults = []
    for name, job in create_jobs(out).items():
        trace = out / f"{name}.csv"
        with console.status(_("drawing {}", name)):
            client = draw_job(name, job, trace)
            rows = read_trace(trace)
            points = [point for points in job for point in points]
            result = measure_drawing(rows, points)
            plot.save_picture(out / f"{name}.png", plot.strokes_of_trace(rows[result.first :], scale), name)
        if result.deviation > LARGEST_DEVIATION:
            result.faults.append(_("strays {:.3f} steps from its line", result.deviation))
        faults += [f"{name}: {fault}" for fault in result.faults]
        table.add_row(
            name, str(len(points)), str(client.packets), str(client.resends), str(result.steps),
            f"{result.time_s:.3f}", f"{result.deviation:.3f}", _("wrong") if result.faults else _("exact"),
        )
    console.print(table)
    console.print(_("off line: largest distance from the ideal line, in steps on the minor axis; at most ½ is exact"))
    console.print(_("pictures and traces in {}/, {:.0f} s", out, time.monotonic() - begun))
    if faults:
        raise Failure("{} faults; the first: {}", len(faults), faults[0])


def _right_column(head):
    """Return a table's column that is aligned to the right."""
    from rich.table import Column

    return Column(head, justify="right")


if __name__ == "__main__":
    try:
        main()
    except Failure as failure:
        print(f"run: {failure.message()}", file=sys.stderr)
        sys.exit(1)
