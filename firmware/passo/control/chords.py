"""An arc that cannot be walked as a circle, handed to the planner chord by chord as it has room.

    chords = Chords(ellipse, nm_s, tool, tag, steps_per_m, accelerations, slowest)
    while chords.left and planner.room():
        chords.add(planner)

Nothing else may be queued meanwhile. The speed along the path is the same on all of them. The corners between them are
the junction deviation's affair: with $11=0 the machine stands at each.
"""

from passo.motion.integers import isqrt, length_nm
from passo.records import COUNT_MASK, NM_PER_M, TICKS_PER_S


class Chords:
    def __init__(self, ellipse, nm_s, tool, tag, steps_per_m, accelerations, slowest):
        """`ellipse`: a motion.ellipse.Ellipse; `accelerations`: of the plane's two axes, in nm/s², that v²/R stays
        within; `slowest`: what the slowest axis can do, in nm/s.

        Raises ValueError where a step would last longer than the planner can say.
        """
        if ellipse.flat_nm:
            nm_s = min(nm_s, isqrt(ellipse.inwards(accelerations) * ellipse.radius_nm) * ellipse.length_nm // ellipse.flat_nm)
        self._nm_s = nm_s or 1
        # A chord of one step on all axes is up to √3 of the coarsest step long.
        if 2 * NM_PER_M * TICKS_PER_S // (min(steps_per_m) * min(self._nm_s, slowest)) > COUNT_MASK:
            raise ValueError("steps more than 43 s apart")
        self._ellipse = ellipse
        self._tool = tool
        self._tag = tag
        self._steps_per_m = steps_per_m
        self.left = ellipse.left
        self.flush = False  # when the last has been added, the planner is to be flushed

    def add(self, planner):
        """Queue the next one; one too short for a step is none."""
        deltas = self._ellipse.chord()
        self.left -= 1
        ticks = length_nm(deltas, self._steps_per_m) * TICKS_PER_S // self._nm_s
        planner.line(deltas, ticks, self._tool, self._tag)
        if self.flush and not self.left:
            planner.flush()
