"""Canned cycles, drawn out into plain motions, in the plane in which the holes lie. All dialects use these, by their numbers of
RS274/NGC.

    cycle = Cycle(83, above=2.0, bottom=-10.0, feed=100.0, peck=3.0)
    cycle.put_hole(path, [5.0, 5.0])        # the tool is above that position, at `above` or higher; ends at `back`
"""

from dataclasses import dataclass

from passo.protocols.gcode.motion import BACK_OFF_NM

BACK_OFF_MM = BACK_OFF_NM / 1_000_000  # retract of G73, and distance of G83 from the bottom so far


@dataclass
class Cycle:
    """Heights in mm of the program. `back`: where Z ends; default `above`."""

    code: int
    above: float
    bottom: float
    feed: float
    dwell: float = 0.0  # seconds
    peck: float = 0.0
    back: float | None = None
    over: float | None = None  # of the way to the first hole; None: as the tool stands
    axes: tuple = (0, 1, 2)  # first and second of the plane, and the one along the hole
    spindle: str = ""  # M3 or M4, what it turns by

    def put_hole(self, path, position):
        """Append the motions of one hole at `position`, on the plane's axes, in mm."""
        self._move_to(path, (*position, self.over), True)
        self.over = None
        self._move_z(path, self.above, True)
        if self.code in (73, 83):
            self._put_pecks(path)
        else:
            self._move_z(path, self.bottom, False)
        turned = {"M3": "M4", "M4": "M3"}.get(self.spindle, "")
        if self.code in (74, 84):  # a tap turns back before it dwells, others dwell before the spindle stops
            path.put_word("M5")
            path.put_word(turned)
        if self.dwell:
            path.put_word(f"G4 P{self.dwell:g}")
        if self.code in (86, 88):
            path.put_word("M5")
        if self.code == 88:
            path.put_word("M0")
        if self.code == 85 or self.code in (74, 84, 89) and self.back is None:
            self._move_z(path, self.above, False)
        elif self.code in (74, 84, 89):  # a tap turns back all the way
            self._move_z(path, self.back, False)
        self._move_z(path, self.above if self.back is None else self.back, True)
        if self.code in (74, 84):
            path.put_word("M5")
        if self.code in (74, 84, 86, 88):
            path.put_word(self.spindle)

    def _put_pecks(self, path):
        """Append the pecks down to `bottom`, `peck` mm each: G73 lifts by BACK_OFF_MM between them, G83 to `above`."""
        reached = self.above
        while reached - self.peck > self.bottom + 1e-9:
            reached -= self.peck
            self._move_z(path, reached, False)
            if self.code == 73:
                self._move_z(path, reached + BACK_OFF_MM, True)
            else:
                self._move_z(path, self.above, True)
                self._move_z(path, min(self.above, reached + BACK_OFF_MM), True)
        self._move_z(path, self.bottom, False)

    def _move_z(self, path, height, rapid):
        self._move_to(path, (None, None, height), rapid)

    def _move_to(self, path, position, rapid):
        """Append a straight line to a position on the plane's axes, in mm; None: the axis stays. A rapid, or at the cycle's feed."""
        target = [None] * 3
        for axis, value in zip(self.axes, position):
            target[axis] = value
        path.move_to(target, rapid, 0.0 if rapid else self.feed)
