"""G45: clears a pocket, rectangular, round or oblong, from its middle outwards, in layers.

    Pocket(centre, half, corner, …).put_motions(path, radius)

The tool goes down in the middle, along the middle line, then around in loops that lie `step` apart; the last one keeps `stock` from
the wall. The rest on floor and wall is taken off at the end.
"""

import math
from dataclasses import dataclass

from host_tools.programs.program_errors import POCKET, ProgramError

_WIDEST_STEP = math.sqrt(2)  # times the radius: more leaves ridges in the corners between two loops


@dataclass
class Pocket:
    """Lengths in mm, feeds in mm/min. `half`: half of its length and width; `corner`: radius of its corners."""

    centre: tuple
    half: tuple
    corner: float
    above: float
    bottom: float
    depth: float  # of a layer
    step: float
    floor: float  # left for the finish, as `stock` on the wall
    stock: float
    clockwise: bool
    feeds: tuple  # down and sideways, and the same of the finish

    def put_motions(self, path, radius):
        """Append all motions of the pocket. Raises ProgramError if the tool does not fit."""
        room = min(self.half) - radius - self.stock
        if radius <= 0 or room < 0:
            raise ProgramError(POCKET, "a tool of radius {:g} in {:g} × {:g} mm", radius, 2 * self.half[0], 2 * self.half[1])
        if self.corner < radius - 1e-6:
            raise ProgramError(POCKET, "corners of radius {:g} for a tool of radius {:g}", self.corner, radius)
        if not 0 < self.step <= _WIDEST_STEP * radius + 1e-9:
            raise ProgramError(POCKET, "steps of Q{:g}: {:.3f} at most with this tool", self.step, _WIDEST_STEP * radius)
        if self.depth <= 0 or self.bottom >= self.above or self.floor < 0 or self.stock < 0:
            raise ProgramError(POCKET, "P, I, J or Z")
        down, along, down_finish, along_finish = self.feeds
        start = [self.centre[0] + self._loop_reach(min(self.half))[0], self.centre[1], None]
        path.move_to(start, True)
        path.move_to([None, None, self.above], True)
        loops = self._loop_insets(radius + self.stock)
        level = self.above
        lowest = self.bottom + self.floor
        while level > lowest + 1e-9:
            level = max(level - self.depth, lowest)
            self._put_layer(path, start, level, loops, down, along)
        if self.floor:
            self._put_layer(path, start, self.bottom, loops, down_finish, along_finish)
        if self.stock:
            self._put_layer(path, start, self.bottom, [radius], down_finish, along_finish)
        path.move_to([None, None, self.above], True)

    def _loop_reach(self, inset):
        return max(0.0, self.half[0] - inset), max(0.0, self.half[1] - inset)

    def _loop_insets(self, least):
        """Return the insets of the loops from the wall in mm, from the inside out."""
        count = math.ceil((min(self.half) - least) / self.step - 1e-9)
        return [min(self.half)] + [least + self.step * each for each in range(count - 1, -1, -1)]

    def _put_layer(self, path, start, level, loops, down, along):
        """Append one layer at the height `level` mm: down at the feed `down`, the loops of these insets (mm) at the feed `along`, mm/min, and back to
        `start`."""
        path.move_to([None, None, level], False, down)
        for inset in loops:
            self._put_loop(path, inset, along)
        path.move_to(start, False, along)

    def _put_loop(self, path, inset, feed):
        """Append one loop, from the middle of the right side; the middle line if the loop has no width."""
        width, height = self._loop_reach(inset)
        x, y = self.centre
        path.move_to([x + width, y, None], False, feed)
        corner = min(max(0.0, self.corner - inset), width, height)
        if not height or not width:
            for end in ((x - width, y - height), (x + width, y + height), (x + width, y)):
                path.move_to([*end, None], False, feed)
            return
        turn = -1 if self.clockwise else 1
        # Corners in their order, each as (its sides' signs); a side leads to the start of the corner's arc.
        for right, up in ((1, turn), (-1, turn), (-1, -turn), (1, -turn)):
            centre = x + right * (width - corner), y + up * (height - corner)
            ends = (centre[0] + right * corner, centre[1]), (centre[0], centre[1] + up * corner)
            first, last = ends if right * up == turn else ends[::-1]
            path.move_to([*first, None], False, feed)
            if corner:
                path.arc_to(17, self.clockwise, [*last, None], (centre[0] - first[0], centre[1] - first[1]), feed)
        path.move_to([x + width, y, None], False, feed)
