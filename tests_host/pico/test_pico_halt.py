"""Halting inputs of the emulated Pico: how soon the steps end, and whether the machine still knows where it is."""

from random import Random

import pytest
from emulated import rig, timer_rig, uf2  # noqa: F401

from host_tools.emulator.copies import on_a_copy
from host_tools.emulator.cycles import CYCLES_PER_US
from host_tools.emulator.halting import INPUTS, INTERRUPT_PIN, PLAYER_PIN, amid_start, try_in_hand, resume_line, set_out, try_halts
from host_tools.emulator.rig import router_board, ticks_of
from passo.ports.rp2.fields import PIO_FIELDS, PIO_STUCK

pytestmark = [pytest.mark.on_a_copy, pytest.mark.xdist_group("rig")]
DELTAS = (2000, 1555, -1250)
RATE_HZ = 100_000
TRIALS = 6


@pytest.mark.parametrize("pin, most_us", [(PLAYER_PIN, 1.0), (INTERRUPT_PIN, 25.0)])
def test_stopped_at_any_moment_it_knows_where_it_is(rig, pin, most_us, show):
    random = Random(pin)
    set_out(rig, DELTAS, RATE_HZ, 2000)
    found = try_halts(rig, pin, [random.uniform(0, 15_000) for _ in range(TRIALS)])
    for reaction_us, reported, counted, _ in found:
        assert reported == counted and any(counted)
        assert reaction_us <= most_us
    show(f"halt from pin {pin}", f"last step at most {max(found)[0]:.1f} µs after the edge, {TRIALS} trials")


def test_a_word_pulled_but_not_played_does_not_count(rig):
    set_out(rig, (8000, 6220, -5000), 400_000, 2000)
    found = try_in_hand(rig, INTERRUPT_PIN, [turn * 3 / 125 for turn in range(1500)])
    assert found, "no freeze fell between pull and out"
    assert found[1] == found[2] and found[3]


def test_a_halted_line_is_taken_up_from_rest_and_ends_where_it_should(rig):
    stood, index, position, edge = resume_line(rig, INTERRUPT_PIN, DELTAS, RATE_HZ, 20_000, 10_000)
    assert position == rig.count_steps() == list(DELTAS)
    assert stood[0] == index and 0 < index < DELTAS[0]
    rises = [cycle for cycle, state in rig.step_edges[0] if state == 1]
    assert len(rises) == DELTAS[0]
    again = [cycle for cycle in rises if cycle > edge + 2000 * 125]
    assert len(again) == DELTAS[0] - index
    assert again[1] - again[0] > 20 * 1250, "from rest: twenty times slower than it was"


HALTED = """
from machine import Pin
pin = Pin(20, Pin.IN)
planner.line(%r, %d, False)
planner.flush()
controller.machine.awake = True
while not pin.value():
    app.cycle()
while pin.value():
    pass
player.%s
"""
PULSE_US = 5


@pytest.mark.parametrize("call", ["hold(1); player.halt()", "stop(); player.hold(1); player.halt()"])
def test_a_halt_cuts_no_pulse_short(rig, call):
    """Whenever it comes: a driver may miss a pulse that is too short, and the firmware has counted it."""
    rig.load_board(router_board(3, inputs=INPUTS, drive={"kind": "step_dir", "pulse_us": PULSE_US, "setup_us": 5}))
    deltas = (1500, 1100, -800)
    rig.clear_edges()
    rig.pico.console.start(HALTED % (deltas, ticks_of(deltas, 25_000), call))
    while not any(rig.step_edges):
        rig.pico.run(200)
    rig.pico.run(6000)
    rig.pico.drive_pin(20, 1)
    rig.pico.run(15_000)

    def widths_us(after_us):
        rig.pico.run(after_us)
        rig.pico.drive_pin(20, 0)
        rig.pico.run(1000)
        assert b"\x04\x04" in rig.pico.console.text and all(log[-1][1] == 0 for log in rig.step_edges)
        return [(fall - rise) / CYCLES_PER_US for log in rig.step_edges for (rise, high), (fall, _) in zip(log, log[1:]) if high]

    found = [on_a_copy(lambda: widths_us(turn * 2.63)) for turn in range(60)]
    assert min(map(min, found)) >= PULSE_US


@pytest.mark.xdist_group("timer")
@pytest.mark.parametrize("by", ["interrupt", "main loop"])
def test_a_halt_of_the_timer_player_cuts_no_pulse_short(timer_rig, by):  # noqa: F811
    """It makes each pulse within its own interrupt, which no other one breaks off."""
    timer_rig.load_board(router_board(3, player="timer", inputs=INPUTS, drive={"kind": "step_dir", "pulse_us": PULSE_US, "setup_us": 5}))
    deltas, hz = (2400, 1600, -1200), 20_000
    if by == "interrupt":
        timer_rig.clear_edges()
        set_out(timer_rig, deltas, hz, 6000)
        pin, level = INTERRUPT_PIN, 1
    else:
        timer_rig.clear_edges()
        program = HALTED.replace("while pin.value()", "print('held')\nwhile pin.value()")
        timer_rig.pico.console.start(program % (deltas, ticks_of(deltas, hz), "hold(1); player.halt()"))  # else the feeder would start it again
        while not any(timer_rig.step_edges):
            timer_rig.pico.run(200)
        timer_rig.pico.drive_pin(20, 1)
        timer_rig.pico.console.expect(b"held")
        pin, level = 20, 0

    def widths_us(after_us):
        timer_rig.pico.run(after_us)
        timer_rig.pico.drive_pin(pin, level)
        timer_rig.pico.run(1000)
        for _ in range(30):  # the script's own call may have to collect garbage first
            if by == "main loop" and b"\x04\x04" not in timer_rig.pico.console.text:
                timer_rig.pico.run(1000)
        assert all(log[-1][1] == 0 for log in timer_rig.step_edges), "no pulse is left on"
        return [(fall - rise) / CYCLES_PER_US for log in timer_rig.step_edges for (rise, high), (fall, _) in zip(log, log[1:]) if high]

    found = [on_a_copy(lambda: widths_us(turn * 2.63)) for turn in range(40)]
    assert min(map(min, found)) >= PULSE_US


@pytest.mark.slow
def test_a_halt_amid_the_start_lets_nothing_begin(rig):
    """At a stand, the input comes while the first words are being handed over: no step follows."""
    for before_us, steps, reported in amid_start(rig, INTERRUPT_PIN, DELTAS, RATE_HZ, range(6, 66, 4)):
        assert not steps and reported == [0, 0, 0], before_us


HANG = """
from passo.motion.limits import Limits
planner.load()
feeder.ramp = planner.ramp
planner.limits(Limits([400000] * 3, [400_000_000] * 3, [20_000_000_000] * 3, 10_000))
planner.line((60000, 45000, -30000), 7_500_000, False)
planner.flush()
controller.machine.awake = True
while feeder.position(player.words_played())[0] < 2000:
    app.cycle()
print("hangs")
while True:
    pass
"""


@pytest.mark.slow
def test_when_the_main_loop_hangs_the_machine_slows_down_to_a_stand(rig, show):
    rig.clear_edges()
    rig.pico.console.start(HANG)
    rig.pico.console.expect(b"hangs")
    hung = rig.pico.cycle
    rig.pico.run(300_000)
    rises = [cycle for cycle, state in rig.step_edges[0] if state == 1]
    stood_ms = (rises[-1] - hung) / 125_000
    gaps = [after - before for before, after in zip(rises, rises[1:])]
    slowing = gaps[-1000:]
    assert 170 < stood_ms < 200, "170 ms of patience, 14 of words already made, 12.5 to slow down"
    assert slowing[0] == 1250 and slowing[-1] > 10 * 1250
    assert all(after >= before - 10 for before, after in zip(slowing, slowing[1:])), "slower and slower, but for a tick"
    assert eval(rig.pico.exec("print(feeder.position(player.words_played()))")) == rig.count_steps()
    show("a main loop that hangs", f"the steps end {stood_ms:.0f} ms later, after a ramp")


STUCK = """
from passo.motion.limits import Limits
planner.load()
feeder.ramp = planner.ramp
planner.limits(Limits([400000] * 3, [400_000_000] * 3, [20_000_000_000] * 3, 10_000))
state, = [value for value in player.__dict__.values() if type(value) is type(planner.rows) and len(value) == %d]  # a build renames it
state[%d] = 1
planner.line((400, 300, -200), 40_000, False)
planner.flush()
feeder.open, feeder.hold, feeder.brake = True, False, False
try:
    for turn in range(200):
        port.wait(True)
except RuntimeError as error:
    print(error)
"""


@pytest.mark.slow
def test_a_player_that_is_stuck_steps_nothing_and_ends_the_main_loop(rig):
    rig.clear_edges()
    assert rig.pico.exec(STUCK % (PIO_FIELDS, PIO_STUCK)) == "the player's DMA or state machine does not answer\r\n"
    assert rig.count_steps() == [0, 0, 0]
