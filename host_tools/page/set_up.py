"""The orders of a page's set-up that the PC computes: a program that faces the work, a height map, a job that follows it.

    orders.update(SetUp(machine, store).orders())

    {"do": "make", "what": "surface", "x": 100, …}          # the answer names the job that has been made
    {"do": "map", "what": "probe", "x0": 0, …}              # a job of touches begins
    {"do": "map", "what": "get"}                            # the answer has what has been touched so far
    {"do": "map", "what": "level", "name": "part.nc"}       # a second job, `part-level.nc`

The map is kept as long as the panel runs. It runs under MicroPython too, in a browser's tab.
"""

from host_tools.programs.height_map import MOST_POINTS, Grid, Unfollowed, level_job
from host_tools.programs.surfacing import surface_lines
from host_tools.page.slow_order import SlowOrder
from passo import errors
from passo.protocols.page.orders import number_field, text_field

SURFACE = "surface.gcode"
PROBING = "height map"
# Least and most of each size; mm, mm/min, per cent.
_SIZES = {"x": (1, 5000), "y": (1, 5000), "tool": (0.1, 200), "overlap": (0, 90), "depth": (0.01, 100), "cut": (0.01, 100), "feed": (1, 100_000),
          "plunge": (1, 100_000), "rpm": (0, 100_000), "safe": (0.5, 200)}  # fmt: skip
_GRID = {"x0": (-5000, 5000), "y0": (-5000, 5000), "x1": (-5000, 5000), "y1": (-5000, 5000), "columns": (2, 50), "rows": (2, 50)}
_TOUCH = {"safe": (0.5, 100), "deep": (0.1, 100), "feed": (1, 2000)}


class SetUp:
    def __init__(self, machine, store):
        self._machine = machine
        self._store = store
        self._grid = None

    def orders(self):
        return {"make": self._make_surface, "map": self._order_map}

    def _make_surface(self, order):
        """Make the job SURFACE, which faces the work, from the order's sizes in mm. Returns the answer or an error. Raises Wrong."""
        if text_field(order, "what", 8) != "surface":
            return errors.UNKNOWN_COMMAND
        lines = surface_lines({name: number_field(order, name, *_SIZES[name]) for name in _SIZES})
        if lines is None:
            return errors.JOB_SIZE
        return self._keep_job("make", SURFACE, "\n".join(lines) + "\n")

    def _keep_job(self, do, name, made):
        """Keep a job that was made. Returns the answer to the order `do`, or an error."""
        error = self._machine.busy_error() or self._store.name_error(name) or self._store.put_job(name, made)
        return error or {"t": "answer", "do": do, "error": 0, "name": name}

    def _order_map(self, order):
        """Carry out an order about the height map: `what` is probe, get, level or drop. Returns 0, an answer, a SlowOrder or an error."""
        what = text_field(order, "what", 8)
        if what == "probe":
            return self._begin_probing(order)
        if what == "get":
            return self._map_answer()
        if what == "level":
            return self._level_job(text_field(order, "name", 64))
        if what == "drop":
            self._grid = None
            return 0
        return errors.UNKNOWN_COMMAND

    def _begin_probing(self, order):
        """Run a job that touches each point of a new height map. Order: corners in mm, columns, rows, feed in mm/min. Returns 0 or an error."""
        size = {name: number_field(order, name, *_GRID[name]) for name in _GRID}
        touch = {name: number_field(order, name, *_TOUCH[name]) for name in _TOUCH}
        columns, rows = int(size["columns"]), int(size["rows"])
        if size["x1"] <= size["x0"] or size["y1"] <= size["y0"] or columns * rows > MOST_POINTS:
            return errors.ORDER_FIELD
        machine = self._machine
        error = machine.refusal() or machine.busy_error()
        if error:
            return error
        grid = Grid(size["x0"], size["y0"], size["x1"], size["y1"], columns, rows)
        lines = [(n + 1, line.replace(" ", "").encode()) for n, line in enumerate(grid.probing_lines(touch["safe"], touch["deep"], touch["feed"]))]
        error = machine.run(PROBING, lines, 1, False, False)
        if not error:
            self._grid = grid
            machine.touched = self._add_touch
        return error

    def _add_touch(self, place):
        """Add a touch to the height map while its job runs. `place`: work coordinates in mm."""
        job = self._machine.job
        if self._grid and job.is_running() and job.name == PROBING and not self._grid.is_whole():
            self._grid.heights.append(place[2])

    def _map_answer(self):
        """The answer with the heights touched so far, in mm."""
        grid = self._grid
        if not grid:
            return {"t": "answer", "do": "map", "error": 0, "heights": None}
        return {"t": "answer", "do": "map", "error": 0, "x0": grid.x0, "y0": grid.y0, "dx": grid.dx, "dy": grid.dy, "columns": grid.columns, "rows": grid.rows,
                "heights": [round(height, 3) for height in grid.heights], "whole": grid.is_whole()}  # fmt: skip

    def _level_job(self, name):
        """Make a second job of `name` that follows the height map, once the map is whole. Returns a SlowOrder or an error."""
        grid = self._grid
        if not grid or not grid.is_whole():
            return errors.NO_SUCH_JOB
        return SlowOrder(lambda: self._follow_map(name, grid), lambda made: made if isinstance(made, (int, dict)) else self._keep_job("map", *made), name, True)

    def _follow_map(self, name, grid):
        """(name, text) of a second job that follows the height map `grid`; if there is none, the number of an error, or an answer that names the
        line that it cannot change."""
        found, size = "", 1
        while len(found) < size:
            piece = self._store.text_piece(name, len(found))
            if isinstance(piece, int):
                return piece
            found, size = found + piece[0], piece[1]
            if not piece[0]:
                break
        stem, dot, kind = name.rpartition(".")
        try:
            made = level_job(found, grid)
        except Unfollowed as unfollowed:
            return {"t": "answer", "do": "map", "error": 0, "line": unfollowed.args[0], "why": unfollowed.args[1]}
        return "%s-level%s%s" % ((stem or name)[:48], dot, kind if dot else ""), made
