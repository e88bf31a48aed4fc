"""A CoreXY plotter on the emulated Pico: its words, homing, a star to the step."""

import pytest
from emulated import make_machine, uf2  # noqa: F401
from test_digest import golden_of_gcode
from test_pico_digest import IN_FLASH, LIMIT_US, with_digest

from host_tools.prove.gcode_jobs import star
from host_tools.emulator.pico import EmulatedPico
from host_tools.sim.machine import VirtualMachine

BOARD = "corexy_plotter"
START = (260, 201)  # steps from the origin


@pytest.mark.slow
def test_the_pico_makes_the_words_of_the_golden_file(uf2, show):  # noqa: F811
    job = "".join(f"{line}\n" for line in star()).encode()
    pico = EmulatedPico(files=with_digest(BOARD, "job.gcode", job), uf2=uf2).boot()
    before = pico.cycle
    code = "import gc\ngc.threshold(16000)\n" + IN_FLASH + f"import digest\ndigest.show_lines('job.gcode', {BOARD!r}, counts=False)"
    said = pico.exec(code, limit_us=3 * LIMIT_US).split()
    show("digest of a star on one belt on the Pico", f"{said[1]} words in {(pico.cycle - before) / 125e6:.2f} emulated s")
    golden = golden_of_gcode()["star"]
    assert [*said[:2], *said[3:]] == [*golden[:2], *golden[3:]]


def drawn(machine, lines):
    """The places of the path after homing, in steps from its end, the origin, which is the plant's to the step."""
    machine.run_until(lambda: b"$X" in machine.replies_so_far() or b"$H" in machine.replies_so_far(), 10_000)
    for line in ["$H", *lines]:
        machine.take()
        machine.send(line.encode() + b"\n")
        machine.run_until(lambda: b"ok" in machine.replies_so_far() or b"error" in machine.replies_so_far(), 60_000)
        assert b"error" not in machine.replies_so_far(), line
        if line == "$H":
            machine.settle()
            assert list(machine.plant.position) == [0, 0]
            homed = len(machine.trace.rows())
    machine.settle()
    assert not machine.plant.errors, machine.plant.errors
    assert list(machine.plant.position) == [0, 0]
    rows = machine.trace.rows()[homed:]
    places = [(row[1] - rows[-1][1], row[2] - rows[-1][2]) for row in rows]
    return [place for before, place in zip([(0, 0), *places], places) if place != before]  # the pen's rows are none


def test_the_pins_draw_what_the_virtual_board_draws(make_machine, show):  # noqa: F811
    """Each place of the axes, in order; back at the origin to the step."""
    lines = star(points=3, centre=(5, 5), size=4)
    wanted = drawn(VirtualMachine(BOARD, start=START), lines)
    machine = make_machine(BOARD, start=START)
    found = drawn(machine, lines)
    assert found == wanted
    show("a star on one belt", f"{len(found)} steps of the axes, as on the virtual board")
