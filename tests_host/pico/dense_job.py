"""A job that keeps three axes at 50 kHz from its first line to its last, as dense in bytes as CAM programs; and the digest of its steps.

    data = dense_job(1_000_000)             # 300 lines a second, 34 bytes each: 98 s
    machine = VirtualMachine(fast_router(), trace=None)
    steps = StepDigest(machine.plant)       # listens from now on, and keeps no rows
    stream(machine, data)
    steps.count, steps.at_speed, steps.digest()
"""

import hashlib
import struct

from host_tools import boards
from passo.records import TICKS_PER_S

STEPS_MM = 320
MAX_MM_MIN = 9375  # 50 000 steps a second
_UNANSWERED = 8  # lines
LINES_S = 300
TURN_MM = 450  # the length at which the long diagonal turns round
STEP_TICKS = TICKS_PER_S // 50_000


def fast_router():
    """The router without switches, its axes 50 kHz fast, and stored jobs."""
    made = {**boards.load("router_3axis"), "homing": None, "jobs": {"language": "grbl"}}
    made["inputs"] = [item for item in made["inputs"] if not item["name"].startswith("limit")]
    made["links"] = [{"name": "serial", "port": "uart0", "tx": 0, "rx": 1, "baud": 115200, "protocol": "grbl"}]
    made["axes"] = [
        {**axis, "steps_per_m": 1000 * STEPS_MM, "travel_steps": 2_000_000, "max_mm_min": MAX_MM_MIN, "accel_mm_s2": 4000}
        for axis in made["axes"]
    ]
    return made


def dense_job(size):
    """G-code of `size` bytes or a few less: along a diagonal in space and back, no line like the one before."""
    end = b"M30\n"
    lines = [b"N1G21G90G94F20000\n"]
    size -= len(lines[0]) + len(end)
    at, way, number = 0.0, MAX_MM_MIN / 60 / LINES_S, 1
    while True:
        number += 1
        if abs(at + way) > TURN_MM:
            way = -way
        at += way
        line = b"N%dG1X%.3fY%.3fZ%.3f\n" % (number, at + number % 7 / 500, at + number % 5 / 500, at + number % 3 / 500)
        size -= len(line)
        if size < 0:
            return b"".join(lines) + end
        lines.append(line)


def stream(machine, data):
    """Send lines to a virtual machine, as a PC does, and wait until all is done."""
    lines = data.splitlines(keepends=True)
    sent = answered = 0
    machine.take()
    while answered < len(lines):
        while sent < len(lines) and sent - answered < _UNANSWERED:
            machine.send(lines[sent])
            sent += 1
        machine.cycle()
        said = machine.take()
        assert b"error" not in said, (said, lines[answered])
        answered += said.count(b"ok\r\n")
    machine.settle(3_600_000)


class StepDigest:
    """Takes the place of a plant's trace."""

    def __init__(self, plant):
        self.count = 0
        self.at_speed = 0  # of them: no more than 2 % behind 50 kHz
        self._first = self._last = 0
        self._start = list(plant.position)
        self._sum = hashlib.sha256()
        plant.trace = self

    def add_row(self, tick, position, _):
        if position == self._start and not self.count:
            return  # the tool's arrival
        if not self.count:
            self._first = tick
        elif (tick - self._last) * 50 <= STEP_TICKS * 51:
            self.at_speed += 1
        self.count += 1
        self._last = tick
        self._sum.update(struct.pack("<q4i", tick - self._first, *[at - then for at, then in zip(position, self._start)], 0))

    def rezero(self, origin):
        """Nothing here has homed."""

    def digest(self):
        return self._sum.hexdigest()

    def seconds(self):
        return (self._last - self._first) / TICKS_PER_S
