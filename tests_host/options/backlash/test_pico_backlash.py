"""A router that takes up backlash on the emulated Pico: its words, and its carriages before a plant with play."""

import pytest
from emulated import make_machine, uf2  # noqa: F401
from test_digest import golden_of_gcode
from test_pico_digest import IN_FLASH, LIMIT_US, with_digest

from host_tools.prove.gcode_jobs import backlash_job
from host_tools.emulator.pico import EmulatedPico
from host_tools.sim.machine import VirtualMachine

BOARD = "router_ballscrew"
START = (700, 700, -700)
PLAY = {"x": 13, "y": 16, "z": 6}  # steps of the board file's play: 40, 50 and 20 µm at 320 steps/mm
LINES = ["G21G90F1500", "G1X4Y4Z-1", "G1X5Y3", "G2X5Y3I1J.5", "G1X4.5Y3.5", "X4.7", "G3X5Y4R1", "G1Z-.5", "X4.99", "X5", "G0X3Y3"]


@pytest.mark.slow
def test_the_pico_makes_the_words_of_the_golden_file(uf2, show):  # noqa: F811
    job = "".join(f"{line}\n" for line in backlash_job()).encode()
    pico = EmulatedPico(files=with_digest(BOARD, "job.gcode", job), uf2=uf2).boot()
    before = pico.cycle
    code = "import gc\ngc.threshold(16000)\n" + IN_FLASH + f"import digest\ndigest.show_lines('job.gcode', {BOARD!r}, counts=False)"
    said = pico.exec(code, limit_us=3 * LIMIT_US).split()
    show("digest of lost motion on the Pico", f"{said[1]} words in {(pico.cycle - before) / 125e6:.2f} emulated s")
    golden = golden_of_gcode()["play"]
    assert [*said[:2], *said[3:]] == [*golden[:2], *golden[3:]]


def gone(machine):
    """The places of the carriages after homing, in order."""
    machine.run_until(lambda: b"$X" in machine.replies_so_far() or b"$H" in machine.replies_so_far(), 10_000)
    for line in ["$X", "$H", *LINES]:
        machine.take()
        machine.send(line.encode() + b"\n")
        machine.run_until(lambda: b"ok" in machine.replies_so_far() or b"error" in machine.replies_so_far(), 60_000)
        assert b"error" not in machine.replies_so_far(), line
        if line == "$H":
            machine.settle()
            assert list(machine.plant.position) == [0, 0, 0]
            homed = len(machine.trace.rows())
    machine.settle()
    assert not machine.plant.errors, machine.plant.errors
    assert list(machine.plant.position) == [960, 960, -160]
    places = [tuple(row[1:4]) for row in machine.trace.rows()[homed:]]
    last = places[-1]
    return [tuple(at - end for at, end in zip(place, last)) for before, place in zip([None, *places], places) if place != before]


@pytest.mark.slow
def test_the_carriages_go_as_on_the_virtual_board(make_machine, show):  # noqa: F811
    """Each place, in order, to the step; the pins' words make no other."""
    wanted = gone(VirtualMachine(BOARD, start=START, play=PLAY))
    found = gone(make_machine(BOARD, start=START, play=PLAY))
    assert found == wanted
    show("lost motion taken up", f"{len(found)} steps of the carriages, as on the virtual board")
