"""The reader of G-code, the queue and the planner, without the feeder: queued blocks are walked at once.

    bench = Bench([320_000, 320_000, 400_000])      # steps a metre
    bench.do("G2 X10 I5")                           # positions after every word of the line, and before the first
"""

from array import array

from check_gcode import Memory
from passo import commands
from passo.control import arcs
from passo.control.program import Program
from passo.control.stream_queue import StreamQueue
from passo.motion.limits import Limits
from passo.motion.line import MAX_RUN
from passo.protocols.gcode.offsets import Offsets
from passo.protocols.gcode.parser import GCode
from passo.records import QUEUE_RETIRED
from rig import Rig

NM_MM = 1_000_000
OUT = array("I", bytearray(4 * MAX_RUN))


class Inputs:
    has_probe = False


class Settings:
    version = 1

    def value(self, which):
        return 1000


class Bench:
    """The reader of G-code, the queue and the planner, without the feeder: queued blocks are walked at once."""

    def __init__(self, steps_per_m):
        rig = Rig(axes=3)
        self.steps_per_m = list(steps_per_m)
        board = {
            "axes": [{"name": "xyz"[i], "steps_per_m": per_m} for i, per_m in enumerate(steps_per_m)],
            "spindle": {"pwm": False},
            "tool": {"on_ms": 0, "off_ms": 0},
        }
        self.planner = rig.planner
        self.planner.limits(Limits(steps_per_m, [50 * NM_MM] * 3, [1000 * NM_MM] * 3, 10_000))
        self.queue = StreamQueue(board, self.planner, rig.feeder, None, None)
        self.arcs = arcs
        self.settings = Settings()
        self.weave = None
        self.inputs = Inputs()
        self.gcode = GCode("xyz", Offsets(3, Memory()), self)
        self.program = Program(board, self, self.queue)
        self.program._limits_of = Settings.version
        self.place = [0, 0, 0]
        self.path = []

    @property
    def target(self):
        return self.queue.target

    def do(self, text):
        """The places after every word of one line, and before the first."""
        path = self.attempt(text)
        assert path, text
        return path

    def attempt(self, text):
        """The same; None where the line is refused."""
        if self.gcode.interpret_line(text.encode()):
            return None
        self.path = [tuple(self.place)]
        for command in self.gcode.commands:
            if command.kind in (commands.LINE, commands.ARC):
                assert self.program._queue_motion(command) == 0, text
                self.play()
                assert self.place == command.target == list(self.queue.target), text
        return self.path

    def play(self):
        planner = self.planner
        self.queue.feed()
        self.queue.flush()
        while not self.queue.empty():
            block = planner.next()
            while block is None:
                self.queue.feed()
                self.queue.flush()
                block = planner.next()
            self._walk(block.walker)
            planner.indices[QUEUE_RETIRED] += 1

    def _walk(self, walker):
        place = self.place
        while walker.left:
            count = min(walker.left, MAX_RUN)
            negative = walker.negative
            walker.walk(OUT, 0, count)
            for word in range(count):
                for axis in range(3):
                    if OUT[word] >> axis & 1:
                        place[axis] += -1 if negative >> axis & 1 else 1
                self.path.append(tuple(place))
