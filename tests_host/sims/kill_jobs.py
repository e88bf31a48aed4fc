"""Programs of G-code that kills.py interrupts: lines, arcs, a laser's picture in lines and in packed rows, offsets, one that is stored, one in frames."""

import random

from host_tools import boards
from host_tools.cli import jobs, stream
from host_tools.drawings.engraving import pack_power
from kills import BAUD, LOST_MS


class Job:
    """A program of G-code that `passo stream` sends."""

    forgotten = False
    name = "router_3axis"
    link = "pc"
    other = "serial"
    axes = 3
    depth = -3 * 400  # steps of Z
    changes = {"journal": {"every_ms": 200, "power": "power"}}
    lost = "stop"
    seek_steps_s = 8000  # a main loop that hangs amid a seek lets it run on for 200 ms, and the hard end lies 5 mm behind the sensor

    def __init__(self, text, **changes):
        self.text = text
        for key, value in changes.items():
            setattr(self, key, value)

    def board(self):
        made = boards.load(self.name)
        made.update(self.changes)
        made["inputs"].append({"name": "power", "pin": 22, "active": 0, "pull": "up"})
        made["homing"].update(seek_steps_s=self.seek_steps_s, locate_steps_s=2000, pull_off_steps=200, debounce_ms=2)
        for link in made["links"]:
            if link["name"] == self.link:
                link.update(lost=self.lost, lost_ms=LOST_MS, **self.of_link())
        return made

    def of_link(self):
        return {}

    def prepare(self, path):
        """Prepare the machine before the program begins."""

    def run(self, path):
        stream.stream(path, "memory", BAUD, "count", False, False, None, 5.0, yes=True)


class Framed(Job):
    def of_link(self):
        return {"frames": True}


class Stored(Job):
    forgotten = True  # the board runs it to its end without the PC, and then forgets it
    changes = {**Job.changes, "jobs": {"language": "grbl"}}

    def prepare(self, path):
        jobs.store(path, "PART", "grbl", False, "memory", BAUD)

    def run(self, path):
        jobs.run("PART", False, True, "memory", BAUD)


class Laser(Job):
    name = "laser_xy"
    other = "usb"
    axes = 2
    depth = None
    seek_steps_s = 1800  # 22.5 mm/s


class StoredLaser(Laser, Stored):
    pass


def _picture(rows=10, columns=16):
    """Grey values, line by line, to and fro, with an overscan."""
    rng = random.Random(5)
    lines = ["G21G90", "G0X4Y5", "M%d S0" % 3, "G1F3000"]
    for row in range(rows):
        y = 5 + row * 0.3
        order = range(columns) if row % 2 == 0 else range(columns - 1, -1, -1)
        lines.append(f"G0X{4 if row % 2 == 0 else 8 + columns * 0.5}Y{y:.2f}S0")
        lines.append(f"G1X{6 if row % 2 == 0 else 6 + columns * 0.5}S0")
        for column in order:
            end = 6 + (column + 1) * 0.5 if row % 2 == 0 else 6 + column * 0.5
            lines.append(f"X{end:g}S{rng.choice((0, 100, 250, 500, 730, 1000))}")
    return "\n".join([*lines, "M5", "G0X2Y2", "M30", ""]).encode()


def _packed(rows=6, dots=80):
    """Dots of 0.1 mm in packed rows of 40, to and fro, one in five dark, with an overscan."""
    rng = random.Random(6)
    lines = ["G21G90", "G0X4Y5", "M3S0", "G1F3000"]
    for row in range(rows):
        begin, end = (6, 6 + dots / 10)[:: 1 if row % 2 == 0 else -1]
        side = 2 if begin < end else -2
        lines += [f"G0X{begin - side:g}Y{5 + row * 0.3:.2f}", f"G1X{begin:g}S0"]
        for to in ((begin + end) / 2, end):
            lines.append(f"X{to:g}S=" + "".join(pack_power(rng.choice((0, 0.1, 0.35, 0.7, 1))) for _ in range(dots // 2)))
        lines.append(f"X{end + side:g}S0")
    return "\n".join([*lines, "M5", "G0X2Y2", "M30", ""]).encode()


LINES = b"G21G90\nM3S9000\nG0Z-2\nG0X10Y10\nG1Z-4F600\nX22F1500\nY18\nX12Y12\nG0Z-2\nM5\nM30\n"
ARCS = b"G21G90\nM3S9000\nG0Z-2\nG0X12Y10\nG1Z-4F600\nG2X20Y10I4J0F1500\nG3X12Y10I-4J3\nG18G2X15Z-5.5I1.5K-0.75\nG17\nG0Z-2\nM5\nM30\n"
OFFSETS = b"""G21G90
M4S5000
M8
G0Z-2
G10L2P2X8Y9
G55
G0X2Y2
G1Z-4F600
G91
X9F1500
Y4
X-4Y-2
G90
G54
G92X0Y0
G1X-3Y-1
G92.1
G20
X0.3Y0.35
G21
G0Z-2
G43.1Z1.5
G0X12Y12
G1Z-5.5F600
X16Y11F1500
G49
G59
G1X14Y8
G54
G0Z-2
M5M9
M30
"""
MIXED = b"""G21G90
G0Z-2
M3S12000
G0X9Y9
G1Z-4F600
G1X14F1800
G2X16Y11I0J2
G1Y15
G3X14Y17I-2
G1X9
Y9.4
G0Z-2
G0X6Y12
G1Z-4.5F500
G93G1X8Y16F30
G94
G1X6Y14F1500
G0Z-2
M5
M30
"""
PICTURE = _picture()
JOBS = {
    "lines": Job(LINES),
    "arcs": Job(ARCS),
    "laser": Laser(PICTURE),
    "packed": Laser(_packed()),
    "offsets": Job(OFFSETS),
    "stored": Stored(MIXED),
    "framed": Framed(MIXED),
    "stored packed": StoredLaser(_packed()),
}
