"""Encoders on the emulated Pico: PIO counts, the processor reads."""

import copy

import pytest
from emulated import rig, uf2  # noqa: F401

from host_tools.emulator.quadrature import Quadrature
from host_tools.emulator.rig import router

pytestmark = [pytest.mark.on_a_copy, pytest.mark.xdist_group("rig")]
PINS = (11, 13, 16, 18)
COUNTS_S = 250_000
# What the encoders of this test count has nothing to do with what the motors step.
UNARMED = "port.encoders.arm = lambda on: None"


def board(axes=4):
    encoders = [
        {"motor": "xyza"[number], "pins": [pin, pin + 1], "pulses": 500, "steps": 400, "reversed": number == 3}
        for number, pin in enumerate(PINS)
    ]
    return router(axes, encoders=copy.deepcopy(encoders))


def counted(rig):
    rig.pico.exec("for i in range(5): sleep_ms(1); app.cycle()")
    return eval(rig.pico.exec("print([port.encoders.count(n) for n in range(4)])"))


def test_four_encoders_at_250_khz_while_three_axes_step_at_100_khz(rig, show):
    rig.fit(board())
    rig.pico.exec(UNARMED)
    wires = [Quadrature(rig.pico, pin, COUNTS_S, 1000 * number) for number, pin in enumerate(PINS)]
    assert counted(rig) == [0, 0, 0, 0]
    turns = ((4000, 4000, 4000, 4000), (-2500, 3000, -1, 4000), (3000, -5000, 3333, -4001))
    for number, wire in enumerate(wires):
        wire.turn(turns[0][number])
    lines = [((1500, -1500, 1500, 0), 100_000), ((-1500, 1500, 1500, 0), 100_000), ((1500, 1500, -1500, 0), 100_000)]
    state = {"round": 0}

    def meanwhile():
        if state["round"] < 2 and not any(wire.left for wire in wires):
            state["round"] += 1
            for number, wire in enumerate(wires):
                wire.turn(turns[state["round"]][number])

    run = rig.play(lines, meanwhile=meanwhile)
    while any(wire.left for wire in wires):
        rig.pico.run(500)
    assert (run.off, run.late) == (0, 0)
    assert run.position == [*rig.counted()[:3], 0]
    wanted = [wire.count for wire in wires]
    assert counted(rig) == wanted[:3] + [-wanted[3]]
    assert sum(map(abs, wanted)) and state["round"] == 2
    show("four encoders at 250 kHz, three axes at 100 kHz", f"no count lost; interrupts leave {run.left():.0%}")


def test_a_change_of_both_pins_counts_nothing_and_the_next_count_is_right(rig):
    rig.fit(board())
    rig.pico.exec(UNARMED)
    wires = [Quadrature(rig.pico, pin, COUNTS_S) for pin in PINS]
    wires[0].turn(6)
    rig.pico.run(500)
    wires[0].jump(2)
    rig.pico.run(500)
    wires[0].turn(2)
    rig.pico.run(500)
    assert counted(rig) == [8, 0, 0, 0]
