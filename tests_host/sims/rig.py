"""A feeder on a bench: planner, ring and drive without a port. Words are taken as fast as they are made."""

from passo.config.board_error import Additions, own_rules
from passo.machine_builder import make_drive
from passo.motion.planner import Planner
from passo.steps.feeder import Feeder
from passo.steps.ring import Ring
from passo.steps.word import COUNT_MASK

SETUP_TICKS = 63
LEAST_TICKS = 25
DRIVES = {
    "step_dir": ("step_dir", "half"),
    "unipolar wave": ("unipolar", "wave"),
    "unipolar full": ("unipolar", "full"),
    "unipolar half": ("unipolar", "half"),
    "pbl3770a full": ("pbl3770a", "full"),
    "pbl3770a half": ("pbl3770a", "half"),
    "pbl3770a eighth": ("pbl3770a", "eighth"),
}


def jerk_limit():
    """limit() of the option for ramps that keep to a jerk; None where it has been taken out."""
    try:
        from passo.options.planning_s_curves.motion import limit
    except ImportError:
        return None
    return limit


class Rig:
    def __init__(self, drive="step_dir", axes=2, reversed_axes=(), size=4096, planner=None):
        kind, mode = DRIVES[drive]
        self.board = {
            "drive": {"kind": kind, "mode": mode},
            "axes": [{"name": "xyza"[i], "reversed": i in reversed_axes} for i in range(axes)],
        }
        for option in own_rules(self.board, {}):
            self.board["additions"] = Additions()
            option.prepare(self.board)
        self.layout, self.drive, self.off = make_drive(self.board)
        self.ring = Ring(size)
        self.planner = planner or Planner(axes)
        self.planner.load(jerk_limit())
        setup = SETUP_TICKS if kind == "step_dir" else 0
        self.feeder = Feeder(self.ring, self.layout, self.planner, self.drive, setup, LEAST_TICKS)
        self.played = 0

    def take(self, lead_ticks=375_000):
        """Fill once, then play everything made: a list of (ticks, levels)."""
        self.feeder.fill(self.played, lead_ticks)
        words = []
        while self.played != self.ring.head:
            word = self.ring.words[self.played & self.ring.mask]
            words.append((word >> self.layout.bits, word & self.layout.levels_mask))
            self.played = (self.played + 1) & COUNT_MASK
        return words

    def run(self):
        """Flush the planner and play it to its end."""
        self.planner.flush()
        words = []
        while not self.planner.empty():
            words += self.take()
            self.feeder.retire(self.played)
        return words

    def steps_of(self, words):
        """[(tick, [step of each axis])] of the words that step, decoded from the levels alone; STEP/DIR only."""
        axes = self.layout.axes
        tick = 0
        steps = []
        for ticks, levels in words:
            if levels & self.layout.step_mask:
                moves = []
                for axis in range(axes):
                    sign = 1 if levels >> (axes + axis) & 1 else -1
                    moves.append(sign if levels >> axis & 1 else 0)
                steps.append((tick, moves))
            tick += ticks
        return steps


def total_ticks(words):
    return sum([ticks for ticks, _ in words])
