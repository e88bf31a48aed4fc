"""Gives a pulse file acceleration: speeds between its steps, so that it starts, turns corners and stops gently.

    text = with_ramps(items, board, accel_mm_s2=200)        # items as pulse_file.items() gives them; the steps stay the same

The file is cut into lines and arcs (recognition.py). At a corner the speed is what the junction deviation of the board file allows
(`planning.junction_um`; S. K. Jeon's approximation, as grbl has it), on an arc v² / R stays within the acceleration, and before a wait,
a question for the speed, a change of drives or of a tool that takes time it is nearly nothing. Between them it follows the trapezoid that
the acceleration allows, in steps of 4 % at most. Played backward the speeds are those of the way forward, so ramps are ramps there too.

A pause or a stop by the operator is at the next step, as without. Each speed takes one cell of the board's memory.
"""

import math

import numpy as np

from host_tools.programs.pulse_file import letter_of
from host_tools.programs.recognition import pieces
from passo.options.step_program.commands import STEPS_ASK, STEPS_DEFAULT, STEPS_FASTEST, STEPS_SPEED, STEPS_TOOL, STEPS_WAIT

_FINER = 1.04  # from one speed to the next at most
_STRAIGHT = math.cos(math.radians(1.0))


def with_ramps(found, board, accel_mm_s2):
    """Return the text of a pulse file with the steps and marks of `found` and speeds that accelerate by `accel_mm_s2` at most."""
    from passo.options.step_program.control_orders import lengths_of

    axes = board["axes"][:3]
    config = board["step_program"]
    lengths = lengths_of([axis["steps_per_m"] for axis in axes])
    fastest = min(lengths[1 << axis] for axis in range(len(axes))) // config["interval_us"]
    maker = _Maker(board, axes, accel_mm_s2, fastest)
    speed = min(config["default_mm_min"], fastest)
    for item in found:
        mask, kind, value = item & 15, item >> 4 & 15, item >> 8
        if mask:
            maker.add_steps(item, speed)
        elif kind in (STEPS_SPEED, STEPS_FASTEST, STEPS_DEFAULT):
            known = {STEPS_SPEED: value, STEPS_FASTEST: fastest}
            speed = min(known.get(kind, config["default_mm_min"]), fastest)
        elif kind == STEPS_TOOL:
            slow = board["tool"].get("on_ms" if value else "off_ms", 0)
            maker.add_mark("(" if value else ")", slow > 0)
        elif kind == STEPS_ASK:
            maker.add_mark("+0", True)
            speed = None  # the operator's, up to the next one of the file
        else:
            maker.add_mark(f"*{value}" if kind == STEPS_WAIT else "[" if value else "]", True)
    maker.write_run()
    return "".join(maker.parts)


class _Maker:
    def __init__(self, board, axes, accel, fastest):
        self.parts = []
        self._accel = float(accel)
        self._deviation = board["planning"]["junction_um"] / 1000
        self._fastest = fastest
        self._mm = np.array([1000 / axis["steps_per_m"] for axis in axes])
        self._arcs = len({axis["steps_per_m"] for axis in axes[:2]}) == 1
        self._items = []  # (item, mm/min) since the last stand
        self._marks = []  # (steps before it, text) of those that need no stand
        self._count = 0
        self._said = None  # the speed in force

    def add_steps(self, item, speed):
        self._items.append((item, speed))
        self._count += item >> 8

    def add_mark(self, text, stands):
        """Add a code's text. `stands`: the machine stands there, so the steps before it are written as a run; other marks keep their place among the
        steps."""
        if stands:
            self.write_run()
            self.parts.append(text + "\n")
            if text == "+0":
                self._said = None
        else:
            self._marks.append((self._count, text))

    def write_run(self):
        """Write the steps collected. The machine stands before and behind them."""
        if self._items:
            moves, tops = self._step_arrays()
            self._write_steps(moves, self._speed_profile(moves, tops))
        else:
            self.parts += [text + "\n" for _, text in self._marks]
        self._items, self._marks, self._count = [], [], 0

    def _step_arrays(self):
        """Return (moves, tops) of the steps collected: an array of steps × axes, each −1, 0 or 1, and the highest speed of each step in mm/s, 0 if it
        has none."""
        from host_tools.programs.pulse_gcode import moves_of

        counts = [item >> 8 for item, _ in self._items]
        tops = np.repeat([0.0 if speed is None else speed / 60 for _, speed in self._items], counts)
        return moves_of([item for item, _ in self._items], len(self._mm)), tops

    def _speed_profile(self, moves, tops):
        """Return the speed of each step in mm/s; 0 where the operator decides."""
        ways = np.abs(moves * self._mm)
        way = np.sqrt((ways**2).sum(axis=1))
        limit = tops.copy()
        gates = np.full(len(moves) + 1, np.inf)  # the most at the boundary before each step
        gates[0] = gates[-1] = 0.0
        at, out = 0, None
        for piece in pieces(moves, self._arcs):
            into, end = self._end_directions(piece)
            if out is not None:
                gates[at] = self._corner_speed(out, into)
            length = way[at : at + piece.count].sum()
            chord = float(np.hypot.reduce(np.array(piece.deltas) * self._mm)) if not piece.centre else length
            if chord:
                way[at : at + piece.count] = chord / piece.count  # evenly along the piece
            if piece.centre:
                radius = math.hypot(*(piece.centre[index] * self._mm[axis] for index, axis in enumerate(piece.plane)))
                limit[at : at + piece.count] = np.minimum(limit[at : at + piece.count], math.sqrt(self._accel * radius))
            at += piece.count
            out = end
        return self._ramp_speeds(limit, gates, way)

    def _ramp_speeds(self, limit, gates, way):
        """Limit speeds (mm/s) forward and backward: v² grows by 2 a s at most. The first and last step of a ramp from rest take their own length."""
        double = 2 * self._accel * way
        top = np.where(limit > 0, limit, self._fastest / 60) ** 2
        square = np.minimum(top, np.minimum(gates[:-1], gates[1:]) ** 2 + double).tolist()
        double = double.tolist()  # one by one lists are quicker
        for order in (range(1, len(square)), range(len(square) - 2, -1, -1)):
            for index in order:
                most = square[index - order.step] + double[index]
                if square[index] > most:
                    square[index] = most
        return np.where(limit > 0, np.sqrt(square), 0.0)

    def _end_directions(self, piece):
        """Return the unit vectors at a piece's start and end."""
        if not piece.centre:
            vector = np.array(piece.deltas) * self._mm
            vector = vector / (np.sqrt((vector**2).sum()) or 1.0)
            return vector, vector
        found = []
        a, b = piece.plane
        for x, y in ((-piece.centre[0], -piece.centre[1]), (piece.deltas[a] - piece.centre[0], piece.deltas[b] - piece.centre[1])):
            vector = np.zeros(len(self._mm))
            sign = -1 if piece.clockwise else 1
            vector[a], vector[b] = -sign * y, sign * x
            found.append(vector / (np.sqrt((vector**2).sum()) or 1.0))
        return found

    def _corner_speed(self, out, into):
        """Return the speed, mm/s, at a corner between two unit vectors, by the junction deviation (S. K. Jeon's formula, as in grbl)."""
        cosine = float(out @ into)
        if cosine > _STRAIGHT:
            return np.inf
        half = math.sqrt(max(0.0, (1 + cosine) / 2))  # sine of half the angle between the sides
        return math.sqrt(self._accel * self._deviation * half / (1 - half)) if half < 1 else np.inf

    def _write_steps(self, moves, speeds):
        """Write steps, with a speed where it changes by a level, and the marks at their places."""
        levels = np.where(speeds > 0, np.round(np.log(np.maximum(speeds, 1e-6)) / math.log(_FINER)), -(10**6)).astype(np.int64)
        masks = np.zeros(len(moves), np.int64)
        for axis in range(moves.shape[1]):
            masks |= (moves[:, axis] != 0).astype(np.int64) << axis | (moves[:, axis] < 0).astype(np.int64) << (4 + axis)
        letters = np.array([letter_of(mask & 15, mask >> 4) if mask else " " for mask in range(128) if _is_step(mask)])
        index = np.cumsum([_is_step(mask) for mask in range(128)]) - 1
        text = letters[index[masks]]
        changes = set((np.flatnonzero(np.diff(levels)) + 1).tolist()) | {0}
        marks = {}
        for place, mark in self._marks:
            marks.setdefault(place, []).append(mark)
        ends = sorted(changes | set(marks) | {len(moves)})
        for begun, end in zip(ends, ends[1:]):
            self.parts += [mark + "\n" for mark in marks.pop(begun, ())]
            if begun in changes and speeds[begun] > 0:
                said = min(max(int(speeds[begun:end].mean() * 60), 1), self._fastest)
                if said != self._said:
                    self.parts.append(f"+{said}\n")
                    self._said = said
            self.parts.append("".join(text[begun:end]) + "\n")
        for rest in marks.values():
            self.parts += [mark + "\n" for mark in rest]


def _is_step(mask):
    """True of the masks that are a step's: axes 0 to 2, and directions of these only."""
    return not mask & 8 and not (mask >> 4) & ~mask & 7
