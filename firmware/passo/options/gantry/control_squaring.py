"""Homing of a gantry: each side finds its own sensor, and both end square.

    both sides slowly until one sensor trips         other      that side stands, the other goes on alone to its sensor
    ───x────────x───  ─►  ─┴──────── x ──            pull off   both together, as far as the one that has less to go
                                                     square     the rest, one side alone

The second side ends offset_steps farther from its sensor than the first from its own. No side moves more than rack_steps alone:
farther away than that, the other sensor was not found, alarm 210.
"""

from passo import errors


class Squaring:
    def __init__(self, board, queue):
        gantry = board["gantry"]
        self.axis = [axis["name"] for axis in board["axes"]].index(gantry["axis"])
        self.sensor = gantry["sensor"]
        self._offset_steps = gantry["offset_steps"]
        self._rack_steps = gantry["rack_steps"]
        self._drive = queue.lend()[0].drive
        self._queue = queue
        self._homing = None
        self._rest = self._alone = 0  # steps that one side has to go alone, and which
        self._stood = 0  # the position of the first side to trip

    def make_phases(self, homing):
        """Return the phases that replace those of `homing` once a sensor has tripped."""
        self._homing = homing
        return self._seek_other_side, self._pull_off_both, self._square_up

    def use_both(self):
        """Let both motors step again."""
        self._drive.use_motors(3)

    def _seek_other_side(self, seeker):
        """Move the side that has not tripped alone to its sensor, rack_steps at most."""
        homing = self._homing
        if seeker.axis != self.axis:
            seeker.done = True
            return
        seeker.note(seeker.tripped)
        other = seeker.sensors[1 - seeker.tripped]
        self._stood = self._queue.axis(seeker.axis)
        self._drive.use_motors(1 if seeker.tripped else 2)
        homing.until(True, errors.ALARM_TWO_MOTORS, other)
        homing.way(seeker, -self._rack_steps, seeker.locate_steps_s)

    def _pull_off_both(self, seeker):
        """Move both sides away from their sensors, by the lesser of their two ways."""
        homing = self._homing
        homing.until(None)
        if seeker.axis != self.axis:
            seeker.note(0)
            homing.way(seeker, seeker.pull_off_steps - homing.steps_from_edge(seeker, 0), seeker.seek_steps_s)
            return
        self.use_both()
        first = seeker.tripped
        seeker.note(1 - first)
        ways = [0, 0]
        ways[first] = seeker.pull_off_steps - (self._stood - seeker.edges[first]) * seeker.away
        ways[1 - first] = seeker.pull_off_steps - homing.steps_from_edge(seeker, 1 - first)
        ways[1] += self._offset_steps
        seeker.ends[1] = seeker.pull_off_steps + self._offset_steps
        less = min(ways)
        self._rest = max(ways) - less
        self._alone = 2 if ways[1] > less else 1
        homing.way(seeker, less, seeker.seek_steps_s)

    def _square_up(self, seeker):
        """Move the side that has more to go alone by the rest of its way."""
        homing = self._homing
        homing.until(None)
        if seeker.axis != self.axis:
            seeker.done = True
            return
        self._drive.use_motors(self._alone)
        homing.way(seeker, self._rest, seeker.locate_steps_s)
