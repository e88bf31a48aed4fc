"""Rows of dots at 500 mm/s on the pins of an emulated Pico, boards/laser_fast.py: where the power is written, when the pin has it, and
the energy that each dot gets in M4, from rest to rest.
"""

import bisect

import numpy as np
import pytest
from emulated import uf2  # noqa: F401

from host_tools.drawings.engraving import pack_power
from host_tools.emulator import rows
from host_tools.emulator.cycles import CYCLES_PER_US
from test_pico_laser import Laser

pytestmark = [pytest.mark.on_a_copy, pytest.mark.xdist_group("laser_fast")]
BOARD = "laser_fast"
STEPS_MM = 80
MM_S = 500
DOTS_A_LINE = 100
_CC, _PWM = 0x0C, 7
PERIOD_US = 20


class Fast(Laser):
    """laser_fast; `writes`: [(cycle, parts of `counts`)] of the compare register, each value once."""

    def __init__(self, uf2):  # noqa: F811
        super().__init__(uf2, board=BOARD)
        self.counts = self.slice.top + 1
        self.writes = [(0, 0)]
        stock = self.slice.write_register

        def write(offset, value):
            stock(offset, value)
            if offset == _CC and self.slice.cc >> 16 != self.writes[-1][1]:
                self.writes.append((self.machine.pico.cycle, self.slice.cc >> 16))

        self.slice.write_register = write
        self.pulses = self.machine.pico.record_edges(_PWM)

    def burn(self, powers, dots_mm, mode):
        """A row there, and one back, each from rest to rest. Returns the cycles of steps."""
        lines = []
        for sign in (1, -1):
            for first in range(0, len(powers), DOTS_A_LINE):
                part = powers[first : first + DOTS_A_LINE]
                lines.append(f"G1X{sign * len(part) / dots_mm:g}S={''.join(pack_power(power / 1000) for power in part)}")
            lines.append("G4P0.02")
        self.say(mode + "S0", f"F{60 * MM_S}")
        del self.steps[:], self.tool[:], self.pulses[:], self.writes[:-1]
        for at in range(0, len(lines), 2):
            self.say(*lines[at : at + 2])  # a board keeps 1024 bytes
        self.settle()
        self.say("M5")
        return np.array(self.places())


@pytest.fixture(scope="module")
def laser(uf2):  # noqa: F811
    return Fast(uf2)


def drawn(count):
    """Powers of a tenth, where it is slow, and more; dark ones among them."""
    return [0 if dot % 7 == 6 else 100 if dot < 8 or dot > count - 6 else 100 + dot * 397 % 901 for dot in range(count)]


def energy(writes, tool, begin, end):
    """Parts of full power × cycles between two cycles, while the tool's pin is high."""
    total = 0.0
    cuts = sorted({begin, end, *(c for c, _ in writes if begin < c < end), *(c for c, _ in tool if begin < c < end)})
    for a, b in zip(cuts, cuts[1:]):
        lit = bisect.bisect_right(tool, (a, 1)) - 1
        if lit >= 0 and tool[lit][1]:
            total += writes[bisect.bisect_right(writes, (a, 1 << 30)) - 1][1] * (b - a)
    return total


def pulses_that_follow(laser):
    """How many pulses of the PWM's pin there are; each is as wide as was written last before it began, a period ago at most."""
    times = [cycle for cycle, _ in laser.writes]
    count = 0
    for (rise, state), (fall, _) in zip(laser.pulses, laser.pulses[1:]):
        at = bisect.bisect_right(times, rise)
        if state and at and rise - times[at - 1] > CYCLES_PER_US and fall - rise < PERIOD_US * CYCLES_PER_US:
            width = (fall - rise) * laser.counts / (PERIOD_US * CYCLES_PER_US)
            assert abs(width - laser.writes[at - 1][1]) < 4, (rise, width, laser.writes[at - 1])
            count += 1
    return count


# At 20 dots/mm half a count of the PWM is 2 % of a tenth's dot at rest.
@pytest.mark.parametrize("dots_mm, within", [pytest.param(10, 0.01, marks=pytest.mark.slow), (20, 0.02)])
def test_a_row_at_500_mm_s(laser, dots_mm, within, show):
    count = 40 * dots_mm
    powers = drawn(count)
    steps = laser.burn(powers, dots_mm, "M4")
    each = STEPS_MM // dots_mm
    row = count * each
    assert len(steps) == 2 * row
    writes, tool = laser.writes, laser.tool
    top_us = 1e6 / (MM_S * STEPS_MM)
    late, off, worst_us = [], [], 0.0
    for way in (0, 1):
        edges = steps[way * row : (way + 1) * row]
        dark = next(cycle for cycle, state in tool if not state and cycle > edges[-1])
        edges = np.append(edges, dark if powers[-1] else edges[-1] + (edges[-1] - edges[-2]))
        assert min(np.diff(edges[:-1])) / CYCLES_PER_US == pytest.approx(top_us, rel=0.01), "the row reaches its speed"
        for dot, power in enumerate(powers):
            begin, end = edges[dot * each], edges[(dot + 1) * each]
            if power and (dot == 0 or powers[dot - 1] != power):
                near = min((abs(cycle - begin), cycle - begin) for cycle, _ in writes)[1]
                late.append(abs(near) / (edges[dot * each + 1] - begin))
                worst_us = max(worst_us, abs(near) / CYCLES_PER_US)
            got = energy(writes, tool, int(begin), int(end)) / laser.counts / CYCLES_PER_US
            off.append((got / (power / 1000 * each * top_us) - 1) if power else got)
    off = np.array(off)
    burning = np.array(powers * 2) > 0
    show(
        f"a row at 500 mm/s, {dots_mm} dots/mm, M4, both ways, from rest to rest",
        f"compare value within {max(late):.3f} of a step of its place, {worst_us:.1f} µs; energy of a dot within {100 * np.abs(off[burning]).max():.2f} %",
    )
    assert max(late) < 1
    assert not off[~burning].any()
    assert np.abs(off[burning]).max() <= within
    assert pulses_that_follow(laser) > 2 * count


@pytest.mark.slow
@pytest.mark.parametrize("think_us", (300, 500))
def test_a_fast_uart_loses_no_byte(uf2, monkeypatch, think_us):  # noqa: F811
    """921 600 baud fill its FIFO in less time than one call of the feeder takes. measure() counts what is lost."""
    monkeypatch.setenv("PASSO_FLASH_MISS", "50")
    machine = rows.fast_laser(200)
    link = next(link["name"] for link in machine.board["links"] if link["port"] == "uart0")
    assert rows.measure_stream(machine, link, "dots", think_us)["late"] == 0
