"""A soak's record of a machine's motion: every step as the plant has decoded it from the pins, and its comparison with the moves asked for.

    witness = Witness(plant, board)
    ...                                     # motion
    steps = witness.take()                  # since the last time
    done = follow(steps, start, moves)      # raises Wrong where the path is none of those moves, in their order
    steps.check_intervals(strict=True)      # … where an axis is too fast, or a word came late
"""

from array import array
from math import hypot

import numpy as np

TICKS_PER_S = 12_500_000
WINDOW = 32  # steps of an axis over which its speed is measured
TOO_FAST = 0.985  # of the shortest interval: ticks are whole, and axes that follow share their leader's
ABRUPT = 8  # times the longest of the intervals before: nothing slows down so
FAST_STEPS_S = 4000  # slower than that a stand within one step is allowed
STALL_S = 0.003
NEAR = 1.001  # steps that an axis which follows may be off its line
ARC_OFF = 1.6  # steps off the circle
VOXEL = 3  # steps: the unit in which paths are compared to find gaps
SHIFT = 1 << 19  # makes a voxel's numbers positive


class Wrong(AssertionError):
    """The machine did what it must not do."""


class Line:
    def __init__(self, target, lit):
        self.target, self.lit = list(target), lit

    def steps_of(self, start):
        """Words with a step."""
        return max(abs(to - at) for to, at in zip(self.target, start))

    def places(self, start):
        """Return its places, a row for each word with a step."""
        count = self.steps_of(start)
        return np.rint(np.array(start) + np.outer(np.arange(1, count + 1), np.array(self.target) - np.array(start)) / max(count, 1)).astype(int)

    def follow(self, places, start):
        """(words of `places` that belong to it, whether it is complete)."""
        count = self.steps_of(start)
        seen = places[:count]
        if len(seen):
            delta = np.array(self.target) - np.array(start)
            ideal = np.array(start) + np.outer(np.arange(1, len(seen) + 1), delta) / count
            off = np.abs(seen - ideal)
            leader = int(np.argmax(np.abs(delta)))
            if off.max() > NEAR or off[:, leader].max() > 1e-6:
                at = int(np.argmax((off.max(1) > NEAR) | (off[:, leader] > 1e-6)))
                raise Wrong(f"step {at} of the line {start} → {self.target} is at {seen[at].tolist()}, the last at {seen[-1].tolist()}")
        return len(seen), len(seen) == count


class Arc:
    """In X and Y, less than a whole turn."""

    def __init__(self, target, centre, clockwise, lit):
        self.target, self.centre, self.clockwise, self.lit = list(target), centre, clockwise, lit

    def places(self, start):
        """Return its places, a row for each step of the path at least."""
        first, last = (np.arctan2(y - self.centre[1], x - self.centre[0]) for x, y, _ in (start, self.target))
        turn = (last - first) % (2 * np.pi) - (2 * np.pi if self.clockwise else 0)
        radius = hypot(start[0] - self.centre[0], start[1] - self.centre[1])
        angles = first + turn * np.linspace(0, 1, int(abs(turn) * radius * 1.3) + 2)
        rows = np.column_stack((self.centre[0] + radius * np.cos(angles), self.centre[1] + radius * np.sin(angles), np.full(len(angles), start[2])))
        return np.rint(rows).astype(int)

    def follow(self, places, start):
        ends = np.flatnonzero((places == np.array(self.target)).all(1))
        count = int(ends[0]) + 1 if len(ends) else len(places)
        seen = places[:count]
        if len(seen):
            x, y = (np.concatenate(([start[axis]], seen[:, axis])) - self.centre[axis] for axis in (0, 1))
            radius = hypot(start[0] - self.centre[0], start[1] - self.centre[1])
            off = np.abs(np.hypot(x, y) - radius)
            turned = np.unwrap(np.arctan2(y, x))
            way = (turned - turned[0]) * (-1 if self.clockwise else 1)
            if off.max() > ARC_OFF or np.diff(way).min() < -2 / radius or np.any(seen[:, 2:] != np.array(start[2:])):
                raise Wrong(f"the arc {start} → {self.target} about {self.centre} leaves its circle by {off.max():.2f} steps")
        return count, bool(len(ends))


def follow(steps, start, moves):
    """(moves that are complete, whether the next one has begun, where it ends). Raises Wrong."""
    at, place = 0, list(start)
    for number, move in enumerate(moves):
        count, whole = move.follow(steps.places[at:], place)
        if count and np.any((steps.tools[at : at + count] > 0) != bool(move.lit)):
            raise Wrong(f"the tool is {'off' if move.lit else 'on'} on the way {place} → {move.target}")
        at += count
        if not whole:
            if at < len(steps.places):
                raise Wrong(f"{len(steps.places) - at} steps more, after {place} → {move.target} was left")
            return number, count > 0, steps.places[at - 1].tolist() if at else place
        place = move.target
    if at < len(steps.places):
        raise Wrong(f"{len(steps.places) - at} steps more than asked for, behind {place}: {steps.places[at].tolist()} …")
    return len(moves), False, place


def cut_by(moves, start):
    """Rows of the places where the tool is on."""
    place, rows = list(start), [np.zeros((0, len(start)), dtype=int)]
    for move in moves:
        if move.lit:
            rows.append(move.places(place))
        place = move.target
    return np.vstack(rows)


def far_from(rows, others):
    """Those `rows` that none of `others` lies beside: within VOXEL steps and a voxel."""

    def numbers(voxels):
        return ((voxels[:, 0] + SHIFT) << 40) + ((voxels[:, 1] + SHIFT) << 20) + voxels[:, 2] + SHIFT

    near = np.unique(others // VOXEL, axis=0)
    beside = [numbers(near + np.array((x, y, z))) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)]
    return rows[~np.isin(numbers(rows // VOXEL), np.unique(np.concatenate(beside)))]


class Steps:
    """Words with a step: `ticks`, `places` (a row a word), `tools`."""

    def __init__(self, ticks, places, tools, before, limits):
        self.ticks, self.places, self.tools = ticks, places, tools
        self._before, self._limits = before, limits

    def __len__(self):
        return len(self.ticks)

    def check_intervals(self, strict):
        """`strict`: nothing has stopped the machine amid a word since."""
        if len(self) < 2:
            return
        between = np.diff(self.ticks)
        if between.min() < min(self._limits) * TOO_FAST - 2:
            raise Wrong(f"two words within {between.min() * 0.08:.1f} µs")
        moved = np.diff(np.vstack((self._before, self.places)), axis=0) != 0
        for axis, limit in enumerate(self._limits):
            ticks = self.ticks[moved[:, axis]]
            if len(ticks) > WINDOW and (ticks[WINDOW:] - ticks[:-WINDOW]).min() < (WINDOW - 2) * limit * TOO_FAST:
                raise Wrong(f"axis {axis} is faster than its speed over {WINDOW} steps")
        if strict and len(between) > 4:
            before = np.max(np.lib.stride_tricks.sliding_window_view(between, 4), axis=1)[:-1]
            late = (between[4:] > ABRUPT * before) & (before < TICKS_PER_S // FAST_STEPS_S) & (between[4:] > STALL_S * TICKS_PER_S)
            if late.any():
                at = int(np.argmax(late)) + 4
                raise Wrong(f"a late word: {between[at] * 0.08:.0f} µs after intervals of {before[at - 4] * 0.08:.0f} µs")


class Witness:
    """`least_ticks`: the shortest interval between two steps of each axis."""

    def __init__(self, plant, least_ticks):
        self.plant = plant
        self.steps = 0  # words with a step, all told
        self._limits = least_ticks
        self._rows = array("q")
        self._at = list(plant.position)
        plant.trace = self

    def add_row(self, tick, position, tool):
        rows = self._rows
        rows.append(tick)
        rows.extend(position)
        rows.append(tool)

    def quiet(self):
        """True if nothing has been recorded since take()."""
        return not self._rows

    def take(self):
        width = len(self._at) + 2
        rows = np.array(self._rows, dtype=np.int64).reshape(-1, width)
        self._rows = array("q")
        before = self._at
        if len(rows):
            places = rows[:, 1:-1]
            moved = (np.diff(np.vstack((before, places)), axis=0) != 0).any(1)
            rows = rows[moved]
        self._at = list(self.plant.position)
        self.steps += len(rows)
        return Steps(rows[:, 0], rows[:, 1:-1], rows[:, -1], before, self._limits)
