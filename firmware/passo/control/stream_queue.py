"""The queue of a machine that moves by commands, not only by stored points: lines at a feed, arcs, waits, power."""

from micropython import const

from passo.control import arcs
from passo.control.queue import Queue
from passo.motion.ellipse import Ellipse
from passo.motion.integers import isqrt, length_nm
from passo.records import COUNT_MASK, NM_PER_M, QUEUE_ADDED, QUEUE_FETCHED, QUEUE_RETIRED, SCRATCH_EAGER
from passo.steps.word import TICKS_PER_MS, TICKS_PER_S

_SILENT_MS = const(20)  # without a line: the stream has ended
_LONGEST_MS = const(80_000)  # of one wait: the planner's limit is 85 s


class Chords:
    """An arc that cannot be walked as a circle, handed to the planner chord by chord as it has room: `left` of them are to come.

    Nothing else may be queued meanwhile. The speed along the path is the same on all of them. The corners between them are the
    junction deviation's affair: with $11=0 the machine stands at each.
    """

    def __init__(self, ellipse, nm_s, tool, tag, steps_per_m, accelerations, slowest):
        """`ellipse`: a motion.ellipse.Ellipse; `accelerations`: of the plane's two axes, in nm/s², that v²/R stays within;
        `slowest`: the speed of the slowest axis, nm/s. Raises ValueError if a step would last longer than the planner can say."""
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
        """Queue the next chord; one shorter than a step queues nothing."""
        deltas = self._ellipse.chord()
        self.left -= 1
        ticks = length_nm(deltas, self._steps_per_m) * TICKS_PER_S // self._nm_s
        planner.line(deltas, ticks, self._tool, self._tag)
        if self.flush and not self.left:
            planner.flush()


class StreamQueue(Queue):
    turns = 0  # of the last axis: see GCode.turns

    def __init__(self, board, planner, feeder, player, port):
        Queue.__init__(self, board, planner, feeder, player, port)
        self.eager = getattr(port, "eager", True)  # False: a digest does not depend on how lines arrive
        planner.scratch[SCRATCH_EAGER] = self.eager
        self.streams = False  # lines have come of late
        self._fresh = False  # they came in the last cycle
        self._fresh_ms = 0  # when they did last
        self.arcs = arcs

    def begin(self):
        """Release what is queued, if the machine stands: a moving one fetches blocks itself. More may follow without a stand
        in between: of several blocks the stream is taken to go on."""
        planner = self._planner
        indices = planner.indices
        fetched = indices[QUEUE_FETCHED]
        if self.waiting and indices[QUEUE_RETIRED] == fetched:
            if (indices[QUEUE_ADDED] - fetched) & COUNT_MASK > 1:
                self._fresh = self.streams = True
                planner.stream(True)
            planner.start()
            self.waiting = self.chords is not None  # the rest of them is not queued yet

    def stream(self, fresh, now_ms):
        """Once a cycle if `fresh`, lines have come since the last one, or while it `streams`. Two such cycles one after the
        other are a stream."""
        if fresh and self._fresh:
            self._planner.stream(True)
        if fresh or self._fresh:
            self._fresh_ms = now_ms
            self.streams = True
        elif (now_ms - self._fresh_ms) & COUNT_MASK > _SILENT_MS:
            self._planner.stream(False)
            self.streams = False
        self._fresh = fresh

    def feed(self):
        """Queue as much of an arc as there is room for, once a cycle of the main loop."""
        while self.chords and self._planner.room():
            self.chords.add(self._planner)
            if not self.chords.left:
                self.chords = None

    def wait(self, ms, tag):
        """Queue a stand of `ms` milliseconds. Needs room for ms // 80 000 + 1 blocks."""
        while ms > 0:
            part = min(ms, _LONGEST_MS)
            self._planner.wait(part * TICKS_PER_MS, self.tool, tag)
            ms -= part
        self.waiting = True

    def go(self, target, nm_s, ticks, tool, tag):
        """Queue a line to `target` (steps, the first axes) at `nm_s`, or of `ticks` if they are not 0; if both are 0, as fast as
        the axes may. Raises ValueError if the planner cannot."""
        if tool != self.tool:
            if self.tool_ms(tool):
                self.fits(self.deltas(target), nm_s, ticks)  # a refused motion leaves the tool as it is
            self._change_tool(tool, tag)
        if not self._planner.accelerates:
            ticks = self._line_ticks(self.deltas(target), nm_s, ticks)
            nm_s = 0
        self._planner.line(self.deltas(target), ticks, tool, tag, not nm_s and not ticks, nm_s)
        self.lead(target)
        self.waiting = True

    def fits(self, deltas, nm_s, ticks):
        """Raise ValueError if go() would, for a line of `deltas`."""
        if not self._planner.accelerates:
            ticks = self._line_ticks(deltas, nm_s, ticks)
        self._planner.fits(deltas, ticks, nm_s)

    def _line_ticks(self, deltas, nm_s, ticks):
        """Return the ticks of a line at `nm_s` if the planner does not accelerate: `ticks`, if they are not 0."""
        return ticks or (self.ticks_at(deltas, nm_s) if nm_s else 1)

    def arc(self, command, ticks):
        """Queue an ARC: at its feed, or in `ticks` if they are not 0. Raises ValueError if neither the planner nor chords can."""
        target, tool = command.target, command.tool
        deltas = self.deltas(target)
        planner = self._planner
        third = 3 - command.first - command.second
        plane = command.first, command.second, third if third < len(deltas) else -1
        changes = tool != self.tool and self.tool_ms(tool) > 0
        turns, tag = command.turns - 1, command.number
        chords = None
        try:
            planner.arc(
                deltas, plane, command.centre, tool, command.clockwise, turns, command.feed, ticks, tag, not changes, command.over_half
            )
        except ValueError:  # no circle in steps, or too steep a helix
            chords = self._cut_into_chords(command, deltas, plane, ticks)
        if changes:
            self._change_tool(tool, tag)
        self.tool = tool
        if chords:
            self.chords = chords
            self.feed()
        elif changes:
            planner.arc(deltas, plane, command.centre, tool, command.clockwise, turns, command.feed, ticks, tag, True, command.over_half)
        self.lead(target)
        self.waiting = True

    def follow(self, chords, command):
        """Queue a motion as `chords`, a Chords or the like: as many as there is room for, the rest by feed()."""
        self._change_tool(command.tool, command.number)
        self.chords = chords
        self.feed()
        self.lead(command.target)
        self.waiting = True

    def _cut_into_chords(self, command, deltas, plane, ticks):
        """Return the Chords of an arc, v²/R within the accelerations of the plane's axes. Raises ValueError."""
        steps_per_m = [axis["steps_per_m"] for axis in self._axes]
        ellipse = Ellipse(deltas, plane, command.centre, steps_per_m, command.clockwise, command.turns - 1, command.over_half)
        nm_s = ellipse.length_nm * TICKS_PER_S // ticks if ticks else command.feed
        slowest, accelerations = self._planner.slowest(plane[:2])
        return Chords(ellipse, nm_s, command.tool, command.number, steps_per_m, accelerations, slowest)

    def ticks_at(self, deltas, nm_s):
        """Return the ticks of a line of `deltas` (steps) at `nm_s` along the path."""
        return length_nm(deltas, [axis["steps_per_m"] for axis in self._axes]) * TICKS_PER_S // nm_s

    def slow_tool(self):
        """Return True if a change of the tool takes time."""
        return self.tool_ms(True) + self.tool_ms(False) > 0
