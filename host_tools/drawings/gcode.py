"""A drawing as G-code, for machines that speak grbl: a laser, a tool on Z, or a tool that M3 lowers and M5 lifts.

    cut = Cut("z", feed=600, depth=1.5, passes=3)
    lines_of(plan, {part.number: cut for part in plan.parts})       # ["G21 G90 G94 G17", "G0 Z2", …]

The drawing's 0;0 is the zero of the work. A line is drawn in all its passes before the next: a closed one goes round again, an
open one back, so the tool is not lifted in between. On Z each pass is deeper by the same step, the last one `depth` below zero.
"""

from dataclasses import dataclass, fields, replace
from functools import partial

from host_tools.failure import Failure
from host_tools.programs import toolpath

TOOLS = ("laser", "z", "m3")
number = partial(toolpath.number_text, decimals=4)
_PEN = "pen"


@dataclass(frozen=True)
class Cut:
    """How a layer is drawn. Lengths in mm, speeds in mm/min; 0: none."""

    tool: str
    feed: float = 1000.0
    plunge: float = 300.0  # speed of Z on its way down
    power: float = 0.0  # S of M3 or M4
    depth: float = 0.0  # below zero, of the last pass
    passes: int = 1
    lift: float = 2.0  # of Z above zero, on the way to the next line
    dwell: float = 0.0  # seconds that the tool takes to go down or up

    def with_values(self, text):
        """Return a Cut with the values of a text, "feed=600,power=300". Raises Failure."""
        kinds = {each.name: each.type for each in fields(Cut) if each.name != "tool"}
        values = {}
        for part in text.split(","):
            name, _, value = part.partition("=")
            try:
                values[name.strip()] = kinds[name.strip()](value)
            except (KeyError, ValueError):
                raise Failure("{!r} is no setting of a layer: NAME=NUMBER is, of {}", part, ", ".join(kinds)) from None
        return replace(self, **values).validate()

    def validate(self):
        """Return this Cut. Raises Failure if a figure is out of range."""
        for name, least in (("feed", 1e-3), ("plunge", 1e-3), ("power", 0), ("depth", 0), ("passes", 1), ("lift", 0), ("dwell", 0)):
            if not least <= getattr(self, name) <= 1e6:
                raise Failure("{}: {:g} cannot be", name, getattr(self, name))
        if self.tool == "m3" and not self.power:
            raise Failure("power: M3 S0 leaves the tool up")
        return self


def usual_cut(board, tool=None):
    """Return the usual Cut of a board file with a tool of TOOLS. `tool` None: its laser, its Z axis, or else the tool's output."""
    spindle = board.get("spindle") or {}
    height = any(axis["name"] == "z" for axis in board["axes"])
    tool = tool or ("laser" if spindle.get("laser") else "z" if height else "m3")
    full = spindle.get("max_rpm") or 1000
    return {
        "laser": Cut("laser", feed=1000.0, power=round(full * 0.3)),
        "z": Cut("z", feed=600.0),
        "m3": Cut("m3", feed=3000.0, power=full),
    }[tool]


class _Writer:
    def __init__(self, steps_per_mm):
        self._steps_per_mm = steps_per_mm
        self.lines = []
        self._feed = None
        self._tool = None  # the last line that switched or lifted it

    def add_line(self, line):
        self.lines.append(line)

    def _set_tool(self, line):
        """Append the line that sets the tool's state, if it is another one. Returns True if it was appended."""
        fresh = line != self._tool
        if fresh:
            self._tool = line
            self.add_line(line)
        return fresh

    def forget_tool(self):
        """Repeat state and feed before the next line, because another tool follows."""
        self._tool = self._feed = None

    def position_words(self, place):
        return " ".join(f"{axis}{number(steps / per_mm)}" for axis, steps, per_mm in zip("XY", place, self._steps_per_mm))

    def feed(self, value):
        """Return the word of a speed, mm/min, or "" if it is in force already."""
        if value == self._feed:
            return ""
        self._feed = value
        return f" F{number(value)}"

    def lift_tool(self, cut):
        """Lift or darken the tool. A spindle goes on."""
        if cut.tool == "z":
            self._set_tool(f"G0 Z{number(cut.lift)}")
        elif cut.tool == "m3":
            self._switch_tool("M5", cut)

    def begin(self, cut):
        """Make the tool ready for lines: switch on the laser or the spindle, at rest."""
        self.lift_tool(cut)
        if cut.tool == "laser":
            self._set_tool(f"M4 S{number(cut.power)}")
        elif cut.tool == "z" and cut.power:
            self.add_line(f"M3 S{number(cut.power)}")

    def stop(self, cut):
        """Lift or darken the tool, and stop a spindle."""
        self.lift_tool(cut)
        if cut.tool == "laser" or cut.tool == "z" and cut.power:
            self.add_line("M5")

    def draw_line(self, points, cut):
        """Append one polyline of points in steps, in all its passes: a closed line goes round again, an open one to and fro. On Z each pass is deeper
        by the same step; behind the last the tool is lifted."""
        self.add_line(f"G0 {self.position_words(points[0])}")
        if cut.tool == "m3":
            self._switch_tool(f"M3 S{number(cut.power)}", cut)
        closed = points[0] == points[-1]
        for index in range(cut.passes):
            if cut.tool == "z" and (not index or cut.depth):
                self._set_tool(f"G1 Z{number(-cut.depth * (index + 1) / cut.passes)}{self.feed(cut.plunge)}")
            way = points if closed or index % 2 == 0 else points[::-1]
            for place in way[1:]:
                self.add_line(f"G1 {self.position_words(place)}{self.feed(cut.feed)}")
        self.lift_tool(cut)

    def _switch_tool(self, code, cut):
        if self._set_tool(code) and cut.dwell:
            self.add_line(f"G4 P{number(cut.dwell)}")


def lines_of(plan, cuts, change=None):
    """Return the lines of G-code of a drawing. `cuts`: {number of a part: Cut}; `change`: lines between two parts, in which {} becomes the number of
    the next part; None: no change."""
    writer = _Writer(plan.steps_per_mm)
    writer.add_line("G21 G90 G94 G17")
    for index, part in enumerate(plan.parts):
        cut = cuts[part.number]
        if index:
            before = cuts[plan.parts[index - 1].number]
            if change is not None:
                writer.stop(before)
                writer.add_line(f"({_PEN} {part.number})")
                for line in change:
                    writer.add_line(line.replace("{}", str(part.number)))
                writer.forget_tool()
            elif (cut.tool, cut.power) != (before.tool, before.power):
                writer.stop(before)
                writer.forget_tool()
        writer.begin(cut)
        for points in part.lines:
            writer.draw_line(points, cut)
    if plan.parts:
        writer.stop(cuts[plan.parts[-1].number])
    writer.add_line("G0 X0 Y0")
    writer.add_line("M30")
    return writer.lines


def pens_at(lines, plan):
    """Return {number of a line of lines_of(), from 1: the Part whose pen it needs} for the lines from the last motion before a change to its first
    line; the machine waits at one of them."""
    parts = {f"({_PEN} {part.number})": part for part in plan.parts}
    found = {}
    for index, line in enumerate(lines, 1):
        if line in parts:
            first = index
            while first > 1 and " X" not in lines[first - 2]:
                first -= 1
            found.update(dict.fromkeys(range(first, index + 2), parts[line]))
    return found
