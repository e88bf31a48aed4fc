"""The interrupt of a halting input on the emulated Pico, while lines come as fast as they can: nothing masks it for long."""

from random import Random

import pytest
from emulated import uf2  # noqa: F401

from host_tools.emulator import gcode
from host_tools.emulator.copies import on_a_copy
from host_tools.emulator.cycles import CYCLES_PER_US

STOP_PIN = 27
PINS = 16 + 13  # the exception of the GPIOs
TRIALS = 100
WITHIN_US = 4
SLICE_US = 0.1
MASK_US = 500
READ = "        data = self.rows[self.at]\n"
MASKED = f"        masked = disable_irq()\n        sleep_us({MASK_US})\n        enable_irq(masked)\n"


def latency_us(pico):
    """From the edge of the input to its interrupt handler."""
    begun = pico.cycle
    pico.drive_pin(STOP_PIN, 1)
    while pico.chip.core.ipsr != PINS:
        assert pico.cycle - begun < 1000 * CYCLES_PER_US, "no interrupt came"
        pico.run(SLICE_US)
    return (pico.cycle - begun) / CYCLES_PER_US


def latencies(machine, waits_us):
    """One for each wait from now, in ascending order."""
    found, now_us = [], 0
    for wait_us in sorted(waits_us):
        machine.pico.run(wait_us - now_us)
        now_us = wait_us
        found.append(on_a_copy(lambda: latency_us(machine.pico)))
    return found


def amid_lines():
    """The longest of TRIALS latencies while lines of 0.2 mm come."""
    machine = gcode.fast_router((0.2,))
    start, _ = gcode.chords(0.2)
    head = gcode.pad_lines("$X", "G21G90G94", f"G92X{start}Y50Z-20", "G1F12000")
    order = bytes(range(gcode.CHORDS // gcode.LINES_A_READ))
    machine.pico.console.send(f"go('0.2.txt',{head!r},{4 + 4 * 400},40,{gcode.LINE_BYTES},{order!r})\n".encode())
    machine.pico.console.expect(b"warm", 5_000_000)
    random = Random(30)
    return max(latencies(machine, [random.uniform(0, 30_000) for _ in range(TRIALS)]))


@pytest.mark.on_a_copy
@pytest.mark.xdist_group("interrupts")
def test_a_halting_input_is_seen_at_once_amid_lines(uf2, show):  # noqa: F811
    longest_us = amid_lines()
    show("from a halting input's edge to its interrupt, amid lines", f"{longest_us:.1f} µs at most")
    assert longest_us <= WITHIN_US


@pytest.mark.slow
@pytest.mark.on_a_copy
@pytest.mark.xdist_group("interrupts")
def test_that_test_sees_interrupts_masked(uf2, monkeypatch):  # noqa: F811
    """As a kernel would that masks them."""
    assert gcode._LINE.count(READ) == 1
    text = "from machine import disable_irq, enable_irq\nfrom time import sleep_us\n" + gcode._LINE.replace(READ, MASKED + READ)
    monkeypatch.setattr(gcode, "_LINE", text)
    assert amid_lines() > WITHIN_US
