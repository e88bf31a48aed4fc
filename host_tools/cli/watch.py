"""`passo watch`: the machine live in a terminal."""

import time
from typing import Annotated

import typer

from host_tools.cli.log import find_link
from host_tools.cli.options import AnyBaud, Port, Protocol
from host_tools.failure import Failure
from host_tools.language import N_, _

_MAP = 48, 18  # characters
_MOST_PLACES = 4000
_DOTS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))  # of a braille character, by row and column
_STATE_COLORS = {"idle": "green", "run": "cyan", "jog": "cyan", "home": "cyan", "hold": "yellow", "door": "yellow", "alarm": "red"}


def watch(
    port: Port = None,
    baud: AnyBaud = None,
    protocol: Protocol = None,
    interval: Annotated[float, typer.Option(min=0.05, max=60, help="Seconds between two looks.")] = 0.2,
    once: Annotated[bool, typer.Option("--once", help="Show it once, and end.")] = False,
):
    """Show the machine live: state, position, line under way, speed, signals, and the way it has gone. Ctrl-C ends it.

    It only asks: nothing moves, nothing is changed. To watch while something else commands the machine, give it a link of its own in the
    board file; one port cannot be used by two programs.

    Examples:

        passo watch
        passo watch --port /dev/ttyUSB1 --protocol grbl --interval 0.1
    """
    from rich.console import Console
    from rich.live import Live

    protocol, port, baud = find_link(port, baud, protocol)
    with _create_client(protocol, port, baud) as client:
        view = View(f"{port}, {protocol}")
        look = _LOOKS[protocol]
        view.add_position(*look(client, {}))
        console = Console()
        if once:
            console.print(view.as_panel())
            return
        fields = {}
        try:
            with Live(view.as_panel(), console=console, auto_refresh=False, screen=console.is_terminal) as live:
                while True:
                    time.sleep(interval)
                    view.add_position(*look(client, fields))
                    live.update(view.as_panel(), refresh=True)
        except KeyboardInterrupt:
            pass
        console.print(view.as_panel())


def _create_client(protocol, port, baud):
    """Return a client of the language on the port."""
    from host_tools.clients.grbl import GrblClient
    from host_tools.clients.plotter import PlotterClient
    from host_tools.clients.pulses import PulsesClient
    from host_tools.clients.torch import TorchClient

    return {"grbl": GrblClient, "torch": TorchClient, "pulses": PulsesClient, "plotter": PlotterClient}[protocol](port, baud)


def _look_at_grbl(client, known):
    """Return (rows, position x, y in mm) of a grbl link. `known`: fields of earlier reports, because a report has some only now and then."""
    from host_tools.cli.status import grbl_rows

    fresh = client.ask_status()
    for gone in ("Pn", "A", "Ln"):  # told only while there is something to tell
        known.pop(gone, None)
    known.update(fresh)
    rows = [row for row in grbl_rows(known, [], []) if row[0]]
    rows.insert(1, (N_("line"), known.get("Ln", "-")))
    positions = [float(part) for part in (known.get("MPos") or known.get("WPos") or "0,0").split(",")]
    return rows, tuple((*positions, 0.0)[:2])


def _look_at_status(client, known):
    """Return (rows, position x, y in the language's unit) of a language whose status is a dict of texts or numbers. Raises Failure without
    an answer."""
    fields = client.status()
    if fields is None:
        raise Failure("the board does not answer")
    rows = [(name, str(value)) for name, value in fields.items()]
    if "place" in fields:
        positions = [float(part) for part in str(fields["place"]).split(",")]
    else:
        positions = [float(fields.get("x", 0)), float(fields.get("y", 0))]
    return rows, tuple((*positions, 0.0)[:2])


_LOOKS = {"grbl": _look_at_grbl, "torch": _look_at_status, "pulses": _look_at_status, "plotter": _look_at_status}


class View:
    """The picture in the terminal: a table of the board's report, and a map of the head's path so far."""

    def __init__(self, title):
        self._title = title
        self._rows = []
        self.positions = []

    def add_position(self, rows, position):
        """Take the rows of a report, and add its position to the map; of more than _MOST_PLACES every second stays."""
        self._rows = rows
        if not self.positions or self.positions[-1] != position:
            self.positions.append(position)
        if len(self.positions) > _MOST_PLACES:
            self.positions = self.positions[::2]

    def as_panel(self):
        """Return the table and the map as a panel of rich."""
        from rich.columns import Columns
        from rich.panel import Panel
        from rich.table import Table
        from rich.text import Text

        table = Table.grid(padding=(0, 2))
        for name, text in self._rows:
            color = _STATE_COLORS.get(text.partition(":")[0].lower(), "") if name == "state" else ""
            table.add_row(Text(_(name), "dim"), Text(text, f"bold {color}".strip() if name == "state" else ""))
        return Panel(Columns([table, Text(braille_map(self.positions, *_MAP))], padding=(0, 4)), title=self._title)


def braille_map(positions, width, height):
    """Return a map of the way along positions in `width` by `height` characters of braille, which have 2 by 4 dots each; the last position is a full
    one. None among the positions: the way goes on elsewhere."""
    wide, high = 2 * width, 4 * height
    xs, ys = zip(*(position[:2] for position in positions if position))
    low_x, low_y = min(xs), min(ys)
    zoom = min((wide - 1) / max(max(xs) - low_x, 1e-9), (high - 1) / max(max(ys) - low_y, 1e-9))
    cells = [[0] * width for _ in range(height)]

    def set_dot(x, y):
        """Set the dot at a position; return the (row, column) of its character."""
        column, row = min(int((x - low_x) * zoom), wide - 1), high - 1 - min(int((y - low_y) * zoom), high - 1)
        cells[row // 4][column // 2] |= _DOTS[row % 4][column % 2]
        return row // 4, column // 2

    for before, after in zip(positions, positions[1:]):
        if before is None or after is None:
            continue
        (x, y), (to_x, to_y) = before, after
        count = max(1, min(400, int(max(abs(to_x - x), abs(to_y - y)) * zoom)))
        for part in range(count):
            set_dot(x + (to_x - x) * part / count, y + (to_y - y) * part / count)
    row, column = set_dot(*positions[-1])
    cells[row][column] = 0xFF
    return "\n".join("".join(chr(0x2800 + cell) for cell in line) for line in cells)
