"""Encoders on the emulated Pico: PIO counts, the processor reads."""

import copy

import gantry
import pytest
import tiers
from emulated import make_machine, uf2  # noqa: F401

from host_tools.emulator.quadrature import Quadrature
from host_tools.emulator.rig import Rig, router_board

pytestmark = [pytest.mark.on_a_copy, pytest.mark.xdist_group("encoders")]
PINS = (11, 13, 16, 18)
INDEX_PIN = 20
COUNTS_S = 250_000
# This test's encoders count freely, not with the motors' steps.
UNARMED = "port.encoders.arm = lambda on: None"


def board(axes=4):
    encoders = [
        {"motor": "xyza"[number], "pins": [pin, pin + 1], "pulses": 500, "steps": 400, "reversed": number == 3}
        for number, pin in enumerate(PINS)
    ]
    encoders[0]["index"] = "index"
    inputs = [{"name": "index", "pin": INDEX_PIN, "active": 1, "pull": "down"}]
    return router_board(axes, encoders=copy.deepcopy(encoders), inputs=inputs)


@pytest.fixture(scope="module")
def rig(uf2):  # noqa: F811
    """A Rig whose build has encoders."""
    return Rig(board(), uf2)


def counted(rig):
    rig.pico.exec("for i in range(5): sleep_ms(1); app.cycle()")
    return eval(rig.pico.exec("print([port.encoders.count_of(n) for n in range(4)])"))


def test_four_encoders_at_250_khz_while_three_axes_step_at_100_khz(rig, show):
    rig.load_board(board())
    rig.pico.exec(UNARMED)
    wires = [Quadrature(rig.pico, pin, COUNTS_S, 1000 * number) for number, pin in enumerate(PINS)]
    assert counted(rig) == [0, 0, 0, 0]
    part = 1 if tiers.current == "all" else 2  # of the way
    turns = [[count // part for count in turn] for turn in ((4000, 4000, 4000, 4000), (-2500, 3000, -1, 4000), (3000, -5000, 3333, -4001))]
    for number, wire in enumerate(wires):
        wire.turn_by(turns[0][number])
    far = 1500 // part
    lines = [((far, -far, far, 0), 100_000), ((-far, far, far, 0), 100_000), ((far, far, -far, 0), 100_000)]
    state = {"round": 0}

    def meanwhile():
        if state["round"] < 2 and not any(wire.left for wire in wires):
            state["round"] += 1
            for number, wire in enumerate(wires):
                wire.turn_by(turns[state["round"]][number])

    run = rig.play(lines, meanwhile=meanwhile)
    while any(wire.left for wire in wires):
        rig.pico.run(500)
    assert (run.off, run.late) == (0, 0)
    assert run.position == [*rig.count_steps()[:3], 0]
    wanted = [wire.count for wire in wires]
    assert counted(rig) == wanted[:3] + [-wanted[3]]
    assert sum(map(abs, wanted)) and state["round"] == 2
    show("four encoders at 250 kHz, three axes at 100 kHz", f"no count lost; interrupts leave {run.share_left():.0%}")


def test_a_change_of_both_pins_counts_nothing_and_the_next_count_is_right(rig):
    rig.load_board(board())
    rig.pico.exec(UNARMED)
    wires = [Quadrature(rig.pico, pin, COUNTS_S) for pin in PINS]
    wires[0].turn_by(6)
    rig.pico.run(500)
    wires[0].jump_by(2)
    rig.pico.run(500)
    wires[0].turn_by(2)
    rig.pico.run(500)
    assert counted(rig) == [8, 0, 0, 0]


def test_an_index_pulse_is_noticed_in_its_interrupt(rig):
    rig.load_board(board())
    rig.pico.exec(UNARMED)
    wires = Quadrature(rig.pico, PINS[0], COUNTS_S)

    def pulse():
        for level in (1, 0):
            rig.pico.drive_pin(INDEX_PIN, level)
            rig.pico.run(50)

    def index():
        return eval(rig.pico.exec("i = port.encoders.indexes[0]; print((i.seen, i.counts_off()))"))

    pulse()
    wires.turn_by(2000)
    rig.pico.run(9000)
    pulse()
    assert index() == (2, 0), "a whole turn of 500 pulses"
    wires.turn_by(-2070)
    rig.pico.run(9000)
    pulse()
    assert index() == (3, -70)
    rig.pico.exec("import micropython\nmicropython.heap_lock()\nport.encoders.check()\ni.on_edge(None)\nmicropython.heap_unlock()")


def test_the_spindles_pulses_are_counted_in_their_interrupt(uf2):  # noqa: F811
    """2 kHz beside three axes; a spike behind an edge is noise. The edge's handler allocates nothing."""
    rig = Rig({**board(), "tachometer": {"input": "index"}}, uf2)
    rig.pico.exec(UNARMED)
    rig.pico.exec("turns = port.make('tachometer', 'index')\nus = turns.us")
    for _ in range(40):
        for level, us in ((1, 20), (0, 10), (1, 20), (0, 450)):
            rig.pico.drive_pin(INDEX_PIN, level)
            rig.pico.run(us)
    count, us = eval(rig.pico.exec("print((turns.count_pulses(), turns.us))"))
    rig.pico.drive_pin(INDEX_PIN, 1)
    rig.pico.run(100)
    again, later = eval(rig.pico.exec("print((turns.count_pulses(), turns.us))"))
    assert count == 40 and again == 41 and later > us
    rig.pico.exec("import micropython\nmicropython.heap_lock()\nturns.on_edge(None)\nmicropython.heap_unlock()")


BAUD = 115_200


def gantry_board():
    """The gantry of the virtual tests, on a UART."""
    made = gantry.board(wait_steps=4, limit_steps=20)
    made["inputs"] = [dict(item, pin={"limit_x": 15, "limit_y": 16}.get(item["name"], item["pin"])) for item in made["inputs"]]
    made["outputs"] = [item for item in made["outputs"] if item["name"] == "enable"]
    made["links"] = [{"name": "serial", "port": "uart0", "tx": 0, "rx": 1, "baud": BAUD, "protocol": "grbl"}]
    made["homing"] = {**made["homing"], "latch": True, "order": " zxy", "locate_steps_s": 1000, "each": {"z": {"pull_off_steps": 300}}}
    return made


@pytest.mark.slow
def test_a_gantry_homes_square_catches_up_and_stops(make_machine, show):  # noqa: F811
    """The whole firmware: latched edges, two motors, PIO encoders, single steps at a stand, the alarm of the interrupt's check."""
    machine = make_machine(gantry_board(), start=(500, 400, -300), racked=17, bounce_ms=2, trace=None)
    machine.run_until(machine.is_listening, 10_000)

    def ask(line, answers=(b"ok\r\n", b"error"), limit_ms=30_000):
        machine.take()
        machine.send(line.encode() + b"\n")
        machine.run_until(lambda: any(answer in machine.replies_so_far() for answer in answers), limit_ms)
        return machine.take().decode()

    assert "ok" in ask("$H")
    assert max(map(abs, machine.plant.position)) <= 1 and abs(machine.plant.skew_steps()) <= 1
    racked = machine.plant.skew_steps()
    ask("G91")
    machine.plant.stall_motor("x2", 7)
    ask("G1X5F1500")
    machine.run_ms(600)
    assert machine.plant.skew_steps() == racked
    assert "142,x2 +7]" in ask("$LOG")
    machine.plant.stall_motor("x2", 10_000)
    said = ask("G1X20F3000", (b"ALARM",)) + ask("$LOG")
    assert "231,x " in said and abs(machine.plant.skew_steps() - racked) <= 20 + 3 * 3000 * 320 // 60_000 + 3
    lag = machine.plant.skew_steps() - racked
    show("a gantry on the emulated Pico", f"homed from 17 steps out of square to {racked}, caught up 7, halted at a lag of {lag}")
