"""README's film of the first minute: the output of `passo`, and the drawing that the virtual plotter's pins make.

    python -m host_tools.cli.first_minute            # writes docs/start/first-minute.svg anew

Each command is run in an empty folder, and the lines are what it prints; the path is that of the trace. An SVG that moves by style
sheets alone: a browser that shows no motion shows the end.
"""

import subprocess
import tempfile
from html import escape
from pathlib import Path

from host_tools import boards
from host_tools.drawings.plot import strokes_of_trace
from host_tools.failure import Failure
from host_tools.interpreter import environment, passo
from host_tools.resources import ROOT
from host_tools.sim.measure import read_trace

FILM = ROOT / "docs" / "start" / "first-minute.svg"
BOARD = "plotter_2014"
LINK = "/tmp/machine"
COMMANDS = (
    "passo examples",
    f"passo board --link {LINK} --time fast --trace pen.csv &",
    f"passo draw examples/map.svg --port {LINK}",
    "passo plot pen.csv --order",
)
DRAWS = 2  # the command during which the pen moves
_SECONDS = 20
_FINISHED_S = 16  # the film begins with the finished drawing, for viewers without motion and for a short look
_TYPING_S, _LINE_S, _DRAWING_S = 0.7, 0.2, 8.0
_WIDTH, _HEIGHT, _TERMINAL, _MARGIN = 1000, 420, 610, 20
_COLUMNS, _ROW = 64, 21
_LEAST_MM = 0.5  # a point nearer to the last than this is left out


def run():
    """Run COMMANDS in an empty folder; return ([(command, lines that it prints)], strokes of the trace in mm). Raises Failure if a command fails."""
    with tempfile.TemporaryDirectory() as folder:
        link = str(Path(folder) / "machine")
        told, board = [], None
        try:
            for command in COMMANDS:
                words = passo("--lang", "en", *command.replace(LINK, link).rstrip(" &").split()[1:])
                options = {"cwd": folder, "text": True, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "env": environment(COLUMNS=str(_COLUMNS))}
                if command.endswith("&"):
                    board = subprocess.Popen(words, **options)
                    lines = [board.stdout.readline()]
                else:
                    if command == COMMANDS[-1]:
                        _end_board(board)
                    done = subprocess.run(words, **options, timeout=300)
                    if done.returncode:
                        raise Failure("{}: {}", command, done.stdout)
                    lines = done.stdout.splitlines()
                told.append((command, [line.rstrip().replace(link, LINK) for line in lines if line.strip()]))
        finally:
            _end_board(board)
        rows = read_trace(Path(folder) / "pen.csv")
    strokes = [points for down, points in strokes_of_trace(rows, boards.steps_per_mm(boards.load(BOARD))) if down]
    return told, [_thin_points(points) for points in strokes]


def _end_board(board):
    """End the virtual board, so that its trace is whole. Raises TimeoutExpired after 120 s."""
    if board is not None and board.poll() is None:
        board.terminate()
        board.wait(120)
        board.stdout.close()


def _thin_points(points):
    """Return a stroke without points nearer than _LEAST_MM to the one before; both ends stay."""
    kept = [points[0]]
    for point in points[1:-1]:
        if abs(point[0] - kept[-1][0]) + abs(point[1] - kept[-1][1]) >= _LEAST_MM:
            kept.append(point)
    return [*kept, points[-1]]


def film_svg(told, strokes):
    """Return the SVG's text. `told`: [(command, lines)]; `strokes`: of the trace, mm."""
    at, y, rows, styles, drawing = 0.0, 34, [], [], (0.0, 1.0)

    def add_text(text, kind, begin):
        """Add a row of the terminal that appears `begin` seconds after the start; negative: it is there from the start."""
        if begin < 0:
            styles.append(f"@keyframes r{len(rows)}{{0%,100%{{opacity:1}}}}")
        else:
            styles.append(f"@keyframes r{len(rows)}{{0%,{100 * begin / _SECONDS:.2f}%{{opacity:0}}{100 * begin / _SECONDS + 0.1:.2f}%,100%{{opacity:1}}}}")
        rows.append(f'<text class="{kind}" style="animation-name:r{len(rows)}" x="{_MARGIN}" y="{y}" xml:space="preserve">{escape(text)}</text>')

    for number, (command, lines) in enumerate(told):
        add_text(f"$ {command}", "typed", at if number else -1)
        at, y = at + _TYPING_S, y + _ROW
        if number == DRAWS:
            drawing = at, at + _DRAWING_S
        for row, line in enumerate(lines):
            late = number == DRAWS and row >= len(lines) - 2  # the bar and the end of the drawing
            add_text(line[:_COLUMNS], "told", at + (_DRAWING_S if late else 0))
            at, y = at + (0 if number == DRAWS else _LINE_S), y + _ROW
        at, y = at + (_DRAWING_S + 1 if number == DRAWS else 0.8), y + 6
    paths = _path_elements(strokes, *drawing, styles)
    begin = "\n".join(styles)
    return f"""<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {_HEIGHT}" width="{_WIDTH}" height="{_HEIGHT}">
<!-- made by python -m host_tools.cli.first_minute -->
<style>
text{{font:15px ui-monospace,Menlo,Consolas,monospace;fill:#c9d1d9}}
.typed{{fill:#7ee787;font-weight:bold}}
text,path{{animation-duration:{_SECONDS}s;animation-iteration-count:infinite;animation-timing-function:linear;animation-delay:-{_FINISHED_S}s}}
path{{fill:none;stroke-width:9;stroke-dasharray:1;stroke-linecap:round;stroke-linejoin:round}}
@media (prefers-reduced-motion:reduce){{text,path{{animation:none}}}}
{begin}
</style>
<rect width="{_WIDTH}" height="{_HEIGHT}" rx="8" fill="#0d1117"/>
<rect x="{_TERMINAL}" y="12" width="{_WIDTH - _TERMINAL - 12}" height="{_HEIGHT - 24}" rx="6" fill="#fff"/>
{chr(10).join(rows)}
{paths}
</svg>
"""


def _path_elements(strokes, begin, end, styles):
    """Return the SVG paths of the strokes: each is drawn in its share, by length, of the time from `begin` to `end` (s); blue first, red last. Adds
    to `styles`."""
    lengths = [sum(abs(a[0] - b[0]) + abs(a[1] - b[1]) for a, b in zip(points, points[1:])) for points in strokes]
    xs, ys = [x for points in strokes for x, _ in points], [y for points in strokes for _, y in points]
    left, top, wide, high = _TERMINAL + 12, 24, _WIDTH - _TERMINAL - 36, _HEIGHT - 48
    scale = min(wide / (max(xs) - min(xs)), high / (max(ys) - min(ys)))
    x0 = left + (wide - scale * (max(xs) - min(xs))) / 2
    y0 = top + (high + scale * (max(ys) - min(ys))) / 2
    done, found = 0.0, []
    for number, (points, length) in enumerate(zip(strokes, lengths)):
        first, last = (100 * (begin + (end - begin) * part / sum(lengths)) / _SECONDS for part in (done, done + length))
        styles.append(f"@keyframes p{number}{{0%,{first:.2f}%{{stroke-dashoffset:1}}{last:.2f}%,100%{{stroke-dashoffset:0}}}}")
        corners = [(round(10 * (x0 + scale * (x - min(xs)))), round(10 * (y0 - scale * (y - min(ys))))) for x, y in points]
        steps = "".join(f"{' ' if b[0] >= a[0] else ''}{b[0] - a[0]}{' ' if b[1] >= a[1] else ''}{b[1] - a[1]}" for a, b in zip(corners, corners[1:]) if a != b)
        hue = round(230 * (1 - done / sum(lengths)))
        found.append(
            f'<path pathLength="1" style="animation-name:p{number}" stroke="hsl({hue},75%,42%)" transform="scale(.1)" '
            f'd="M{corners[0][0]} {corners[0][1]}l{steps.strip()}"/>'
        )
        done += length
    return "\n".join(found)


if __name__ == "__main__":
    FILM.write_text(film_svg(*run()), encoding="utf-8")
