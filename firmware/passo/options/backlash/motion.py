"""The planner of a machine with lost motion: each reversal takes it up in its own block, without a stop.

    planner = backlash.Planner(3, board)        # as of manifest.py: board["additions"].value(160) is µm of X
    planner.follow_motors(feeder_position)      # where the motors stand, as a function
    planner.to_axes(motors)                     # positions of the motors to those of the axes, of what has been retired

    motor    ____╱╲            An axis moves with its motor once the play is taken up: what is taken up, 0 … play, is `taken`,
             ╱     ╲           all of it behind a move forth, nothing behind one back. Motor = axis + taken + `offset`.
    axis   ╱  ‾‾‾╲   ╲
         ╱  play →   ╲

A line that turns an axis round gets the steps that are missing. They come in its first part, as long as the corner rule asks for:
there the axis may gain the speed at once with which a corner may be passed, √(8 · acceleration · junction deviation); a shorter line
takes them as a whole. The planner limits both parts as any line, so no motor passes its limits, and the end of each block is
the axis's to the step. Arcs come in chords: each quadrant turns an axis round.

The play taken up is exact at any step of a block: an axis goes one way within a block, so taken = taken at its beginning + the motor's
steps since, within 0 … play. `_begins` keeps both for each row of the queue.
"""

from array import array

from passo.arrays import zeros
from passo.motion import planner
from passo.motion.integers import isqrt
from passo.records import *


class Planner(planner.Planner):
    def __init__(self, axes, board):
        planner.Planner.__init__(self, axes)
        self._additions = board["additions"]
        self._plays, self._taken, self._offset, self._motors, self._first, self._rest = [array("i", [0] * axes) for _ in range(6)]
        self._begins = zeros(QUEUE_SIZE * 2 * axes)  # of each row: the motors' positions at its beginning, and the play taken up there
        self._where = None
        self._lost = True  # `_motors` is to be asked for
        self.plays = False  # an axis has play

    def follow_motors(self, where):
        """Call `where()` for the motors' positions, in steps since power-up, whenever they are not known."""
        self._where = where

    def limits(self, limits):
        """Take the limits of the axes, and $160 to $163 in µm, from which the play in steps follows. Each axis stays where it is. Only at a stand.
        Returns the limits."""
        limits = planner.Planner.limits(self, limits)
        self.plays = False
        for axis in range(self.axes):
            play = (self._additions.value(160 + axis) * limits.steps_per_m[axis] + 500_000) // 1_000_000
            taken = self._taken[axis]
            now = play if taken == self._plays[axis] and taken else min(taken, play)
            self._offset[axis] += taken - now  # the axis stays at its position
            self._taken[axis] = now
            self._plays[axis] = play
            self.plays = self.plays or play > 0
        self._lost = True
        if self.plays:
            self.ready = False
        return limits

    def to_axes(self, motors):
        """Turn `motors`, steps since power-up as of the block retired last, into positions of the axes, in place. Returns it."""
        indices = self.indices
        retired = indices[QUEUE_RETIRED]
        amid = retired != indices[QUEUE_ADDED] and self.plays
        at = retired % QUEUE_SIZE * 2 * self.axes
        for axis in range(self.axes):
            motors[axis] -= self._offset[axis] + (self._play_at(at, axis, motors[axis]) if amid else self._taken[axis])
        return motors

    def _play_at(self, at, axis, motor):
        """Return the steps of play taken up at the motor's position `motor`, in the row whose beginning is _begins[at:]."""
        taken = self._begins[at + self.axes + axis] + motor - self._begins[at + axis]
        return max(0, min(taken, self._plays[axis]))

    def play_taken(self):
        """Return the steps of play taken up at the end of the queue, seven bits an axis; 127 means 127 or more."""
        found = 0
        for axis in range(self.axes):
            found |= min(self._taken[axis], 127) << 7 * axis
        return found

    def stop(self, motors):
        """Note that the motors have stopped at `motors`, perhaps amid a block. The caller drops all that is queued next."""
        indices = self.indices
        retired = indices[QUEUE_RETIRED]
        if retired != indices[QUEUE_ADDED] and self.plays:
            for axis in range(self.axes):
                self._taken[axis] = self._play_at(retired % QUEUE_SIZE * 2 * self.axes, axis, motors[axis])
        self._lost = True

    def room(self):
        """Return how many blocks fit in, one less than the base says: a line may take two."""
        return max(planner.Planner.room(self) - 1, 0)

    def _add(self, at, kind, tool, tag, rapid=False, first=0):
        """Note in `_begins` where the motors are, and the play taken up, at the beginning of the row; then add it. See the base."""
        if self.plays:
            if self._lost:
                self._lost = False
                self._motors[:] = self._where()
            begins = at // self._stride * 2 * self.axes
            self._begins[begins : begins + self.axes] = self._motors
            self._begins[begins + self.axes : begins + 2 * self.axes] = self._taken
        planner.Planner._add(self, at, kind, tool, tag, rapid, first)

    def line(self, deltas, ticks, tool, tag=0, rapid=False, speed_nm_s=0):
        """Queue a line, as the base does; one that turns an axis round becomes two blocks, of which the first takes up the play. Raises
        ValueError."""
        if not self.plays or not self._split_reversal(deltas, ticks, speed_nm_s):
            planner.Planner.line(self, deltas, ticks, tool, tag, rapid, speed_nm_s)
            self._note_queued(deltas)
            return
        first, rest = self._first, self._rest
        power = self.power
        some, others = self._share_ticks(deltas, ticks)
        if any(rest):
            planner.Planner.fits(self, rest, others, speed_nm_s)
        planner.Planner.fits(self, first, some, speed_nm_s)
        if power > POWER_MOST:
            self.power = 0  # the row of dots is the second part
        planner.Planner.line(self, first, some, tool, tag, rapid, speed_nm_s)
        self.power = power
        self._note_queued(first)
        if any(rest):
            planner.Planner.line(self, rest, others, tool, tag, rapid, speed_nm_s)
            self._note_queued(rest)

    def fits(self, deltas, ticks, speed_nm_s):
        """Raise ValueError if the base would refuse the line, or one of its two parts."""
        if self.plays and self._split_reversal(deltas, ticks, speed_nm_s):
            some, others = self._share_ticks(deltas, ticks)
            planner.Planner.fits(self, self._first, some, speed_nm_s)
            deltas, ticks = self._rest, others
            if not any(deltas):
                return
        planner.Planner.fits(self, deltas, ticks, speed_nm_s)

    def _note_queued(self, ways):
        """Note that a line of `ways`, steps of each motor, has been queued."""
        if self.plays:
            for axis in range(self.axes):
                way = ways[axis]
                if way:
                    self._motors[axis] += way
                    self._taken[axis] = self._plays[axis] if way > 0 else 0

    def _split_reversal(self, deltas, ticks, speed_nm_s):
        """Split a line that turns an axis round into `_first`, in which it takes up the play, and `_rest`. Returns False if it turns none."""
        turned = False
        first, rest = self._first, self._rest
        for axis in range(self.axes):
            way = deltas[axis]
            rest[axis] = way
            first[axis] = 0 if not way else self._plays[axis] - self._taken[axis] if way > 0 else -self._taken[axis]
            turned = turned or first[axis] != 0
        if not turned:
            return False
        length = self._limits.length(deltas)
        part = 0 if self.power > POWER_MOST else min(self._reversal_nm(length, ticks, speed_nm_s), length)
        if 2 * part > length:
            part = length
        for axis in range(self.axes):
            way = abs(deltas[axis]) * part // length
            way = way if deltas[axis] > 0 else -way
            first[axis] += way
            rest[axis] -= way
        return True

    def _reversal_nm(self, length, ticks, speed_nm_s):
        """Return the length along the path, nm, in which the play in `_first` may be taken up: the motor then gains no more speed at once than √(8 ·
        acceleration · junction deviation)."""
        limits = self._limits
        if ticks:
            speed_nm_s = length * TICKS_PER_S // ticks
        speed_nm_s = min(speed_nm_s or limits.fastest, limits.fastest)
        most = 0
        for axis in range(self.axes):
            if self._first[axis]:
                play = abs(self._first[axis]) * NM_PER_M // limits.steps_per_m[axis]
                gain = isqrt(8 * limits.accelerations[axis] * limits.junction_deviation) or 1
                most = max(most, play * speed_nm_s // gain, play)
        return most

    def _share_ticks(self, deltas, ticks):
        """Return the ticks of `_first` and of `_rest`, so that the line keeps the speed that it has without play: `ticks` in all; 0, 0 if that is
        0."""
        if not ticks:
            return 0, 0
        length = self._limits.length(deltas)
        return [ticks * self._limits.length(ways) // length or 1 for ways in (self._first, self._rest)]

    def arc(self, deltas, plane, center, tool, clockwise=False, turns=0, speed_nm_s=0, ticks=0, tag=0, queued=True,
            over_half=None):
        """Queue an arc, as the base does. Raises ValueError if an axis has play: each quadrant turns an axis round, so the arc has to come as
        chords."""
        if self.plays:
            raise ValueError("an arc turns axes round: chords")
        planner.Planner.arc(self, deltas, plane, center, tool, clockwise, turns, speed_nm_s, ticks, tag, queued, over_half)
