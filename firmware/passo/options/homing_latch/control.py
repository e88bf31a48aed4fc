"""How well homing repeats: the edges that it has found, again and again, in steps.

    quality.begin(10)               # ten runs behind the one that finds zero, which is discarded
    quality.again(groups)           # a run has ended; True if there is another to come
    quality.rows()                  # [(axis, side, runs, range, σ in hundredths of a step, drift)], or None

A run begins where the one before has ended, a pull-off from the edge that it found: its edge lies from the last one by the difference to
the pull-off, and from the first by the sum of the differences. Drift is the mean of the last third less that of the first.
"""

from math import sqrt

from passo.control.feature import Feature


class Quality(Feature):
    def __init__(self, board, machine, queue):
        Feature.__init__(self, board, machine, queue)
        machine.quality = self
        self.begin(0)

    def begin(self, runs):
        """Begin `runs` runs; 0: measure nothing."""
        self._runs = self._left = runs
        self._edges = {}  # {(axis, side): [steps from the edge of the first run, of each]}

    def again(self, groups):
        """End a run: keep the edges of its seekers. Returns True if another run is to follow."""
        if not self._runs:
            return False
        for group in groups:
            for seeker in group:
                for side in range(len(seeker.sensors)):
                    self._add_edge((seeker.axis, side), (seeker.edges[side] - seeker.start) * seeker.away + seeker.ends[side])
        self._left -= 1
        return self._left >= 0

    def _add_edge(self, key, beyond):
        """Keep a run's edge, which lies `beyond` steps from that of the run before."""
        edges = self._edges.get(key)
        if edges is None:
            self._edges[key] = []  # the first run began anywhere
        else:
            edges.append((edges[-1] if edges else 0) + beyond)

    def rows(self):
        """Return [(axis, side, runs, range, σ, drift)] in steps, σ in hundredths of one; None if nothing was measured."""
        return [self._judge_axis(key) for key in sorted(self._edges)] if self._runs else None

    def _judge_axis(self, key):
        """Return the row of (axis, side)."""
        edges = self._edges[key]
        runs = len(edges)
        mean = sum(edges) / runs
        sigma = sqrt(sum([(edge - mean) ** 2 for edge in edges]) / max(runs - 1, 1))
        third = max(runs // 3, 1)
        drift = (sum(edges[-third:]) - sum(edges[:third])) / third
        return key + (runs, max(edges) - min(edges), int(100 * sigma + 0.5), int(drift + 0.5) if drift > 0 else -int(0.5 - drift))
