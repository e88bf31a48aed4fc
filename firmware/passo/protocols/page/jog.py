"""A continuous jog out of short ones: never more is queued than a moment's way and the way to brake.

    jog = Jog(say)
    jog.begin((1, 0, 0), 3000, limits, position)    # direction, mm/min
    jog.report(position)                            # the machine is there now: what is missing is queued

If whoever feeds it dies, or the cable is cut, the machine comes to its stand by itself: the queue ends at rest.
"""

AHEAD_S = 0.12  # way that is queued, beyond the way to brake
_LEAST_MM = 0.02
_SHORTEST_MM = 0.05  # at a limit of the travel: nearer than that is there
_SHY_MM = 20.0


class Limits:
    """Of each axis: mm/min and mm/s²."""

    def __init__(self, speeds, accelerations):
        self.speeds = speeds
        self.accelerations = accelerations

    def limits_along(self, direction):
        """(mm/min, mm/s²) along a unit vector at which each axis stays within its own limits."""
        used = [axis for axis in range(len(direction)) if direction[axis]]
        speed = min([self.speeds[axis] / abs(direction[axis]) for axis in used])
        return speed, min([self.accelerations[axis] / abs(direction[axis]) for axis in used])


class Jog:
    def __init__(self, say):
        """`say(position, mm/min)`: queue a straight jog to machine coordinates in mm; False if it cannot be queued now."""
        self._say = say
        self.active = False
        self.waiting = False  # a jog is queued and not answered

    def begin(self, direction, speed, limits, position):
        """Go from `position` (mm) along `direction`, at `speed` mm/min or what the axes allow."""
        size = sum([part * part for part in direction]) ** 0.5
        self._way = [part / size for part in direction]
        most, acceleration = limits.limits_along(self._way)
        self._speed = min(speed, most)
        per_s = self._speed / 60
        self._ahead_mm = per_s * AHEAD_S + per_s * per_s / (2 * acceleration) + _LEAST_MM
        self._start = list(position)
        self._said_mm = 0.0  # along the way
        self._most_mm = _SHY_MM + self._ahead_mm  # of one piece: smaller near the end of the travel
        self.active = True
        self.waiting = False
        self.report(position)

    def report(self, position):
        """Queue the next piece if less than the jog needs is queued ahead of `position` (mm)."""
        if not self.active or self.waiting:
            return
        done = sum([(position[axis] - self._start[axis]) * self._way[axis] for axis in range(len(self._way))])
        piece = min(done + self._ahead_mm - self._said_mm, self._most_mm)
        if piece < _LEAST_MM:
            return
        self._piece = piece
        target = [self._start[axis] + self._way[axis] * (self._said_mm + piece) for axis in range(len(self._way))]
        self.waiting = self._say(target, self._speed)

    def take_answer(self, error):
        """Take the answer to the last piece; `error` 0: accepted. Halve the pieces if one was refused, down to _SHORTEST_MM at the travel's end."""
        self.waiting = False
        if not error:
            self._said_mm += self._piece
        elif self._piece > _SHORTEST_MM:
            self._most_mm = self._piece / 2
        else:
            self.active = False

    def end(self):
        self.active = False
