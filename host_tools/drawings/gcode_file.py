"""A G-code file as a drawing: the lines that its tool draws, arcs followed; a layer is a tool (T).

    file = GcodeFile("sign.gcode")
    page = file.outlines(deviation_px=0.1)

If Z moves, a line is drawn that is no rapid and lies at or below Z0, or below the highest Z if none does. Else it is drawn while M3 or
M4 have the tool on, at an S above 0; if nothing says so, each line but rapids. Variables, subprograms and cycles are carried out.
"""

import re

import numpy

from host_tools.drawings.page import Ink, Page
from host_tools.failure import Failure
from host_tools.programs import compiler

_MM_PX = 96 / 25.4
_LEAST_PX = 1.0
_SAME_MM = 1e-6
_MOTION = re.compile(r"G[0-3] ")
_WORD = re.compile(r"([MST])(-?[\d.]+)")


class GcodeFile:
    def __init__(self, path):
        """Raises Failure if the program cannot be carried out, or draws nothing."""
        dialect = compiler.detect_dialect(path)[0]
        program = compiler.compile_file(path, "ngc" if dialect == "plain" else dialect, start=(0.0, 0.0, 0.0))
        strokes = list(_find_strokes(program.listing))
        heights = {round(place[2], 6) for _, _, _, points in strokes for place in points[-1:]}
        self._lines = {}
        if len(heights) > 1:
            surface = _SAME_MM if min(heights) <= 0 else max(heights) - _SAME_MM
            drawn = [(tool, points) for rapid, tool, _, points in strokes if not rapid and max(place[2] for place in points) <= surface]
        else:
            switched = any(power for _, _, power, _ in strokes)
            drawn = [(tool, points) for rapid, tool, power, points in strokes if not rapid and (power or not switched)]
        for tool, points in drawn:
            line = numpy.array([complex(x, y) for x, y, _ in points])
            lines = self._lines.setdefault(tool, [])
            if len(line) < 2 or not abs(numpy.diff(line)).any():
                continue
            if lines and lines[-1][-1] == line[0]:
                lines[-1] = numpy.concatenate((lines[-1], line[1:]))
            else:
                lines.append(line)
        everything = [line for lines in self._lines.values() for line in lines]
        if not everything:
            raise Failure("{} draws nothing: no line with the tool down", path)
        places = numpy.concatenate(everything)
        self._corner = complex(places.real.min(), places.imag.max())
        size = places.real.max() - places.real.min(), places.imag.max() - places.imag.min()
        self.size_px = tuple(max(_LEAST_PX, float(side) * _MM_PX) for side in size)

    def outlines(self, deviation_px, progress=None, by_colour=False, fills=False, unseen=False):
        """Return the page. Arcs are as fine as the compiler makes them, 0.01 mm."""
        page = Page(self.size_px, by_colour=by_colour)
        for tool, lines in sorted(self._lines.items()):
            page.add_inks(max(1, tool), None, [Ink(f"T{tool}", [(line - self._corner).conjugate() * _MM_PX for line in lines])])
        return page


def _find_strokes(listing):
    """Yield (rapid, tool, power, points in mm) of each motion of a listing."""
    strokes = iter(listing.strokes)
    tool, power, on = 1, 0.0, False
    stated = None
    for code in listing.codes:
        for letter, value in _WORD.findall(code):
            number = float(value)
            if letter == "T":
                tool = int(number)
            elif letter == "S":
                stated = number
            elif number in (3, 4, 5):
                on = number != 5
        power = (1.0 if stated is None else stated) if on else 0.0
        if _MOTION.match(code) and any(axis in code for axis in "XYZIJK"):
            stroke = next(strokes, None)
            if stroke is not None:
                yield stroke.rapid, tool, power, stroke.points
