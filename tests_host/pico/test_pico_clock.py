"""The emulated Pico at each clock that a board file may ask for: pulses, serial lines, timers and PWM are the same."""

import pytest
from emulated import PWM_PIN, SPINDLE, make_machine, pwm_rig, rig, timer_rig, uf2  # noqa: F401

from host_tools import boards
from host_tools.emulator import native, system_clock
from host_tools.emulator.cycles import CYCLE_NS, CYCLES_PER_TICK, CYCLES_PER_US
from host_tools.emulator.halting import INPUTS
from host_tools.emulator.pico import EmulatedPico
from host_tools.emulator.rig import router_board
from host_tools.emulator.system_clock import Undervolted
from host_tools.emulator.traffic import move_packets

COLLECT = "gc.collect()"
BAUD = 115_200
POINTS = 40
FLASH_DIVIDER = 0x14  # of the SSI
RAISE = """
import machine
from machine import mem32
from time import ticks_us, sleep_ms
mem32[0x40064000] = 0xC1
sleep_ms(1)
def took():
    begun = ticks_us()
    for _ in range(500):
        pass
    return ticks_us() - begun
"""
PROBE_PIN = 21
LINES = [((1200, 800, -700), 100_000), ((-4800, -4000, 4000), 400_000)]
CLOCKS = [pytest.param(125, marks=pytest.mark.slow), pytest.param(150, marks=pytest.mark.slow), 200]
MHZ = pytest.mark.parametrize("mhz", CLOCKS)


def at_clock(rig, mhz, **changes):
    rig.load_board(router_board(3, inputs=INPUTS, clock_mhz=mhz, **changes))
    rig.pico.exec("app.cycle()")  # until the main loop has turned, a feeder lets out what the motors are not awake for
    assert system_clock.clock_of(rig.pico.chip).hz == mhz * 1_000_000
    assert rig.pico.exec("import machine; print(machine.freq())").strip() == str(mhz * 1_000_000)
    return rig


@pytest.mark.on_a_copy
@pytest.mark.xdist_group("rig")
@MHZ
def test_pulses_and_answers(rig, mhz, show):
    at_clock(rig, mhz)
    rig.wire().feed(move_packets(POINTS), BAUD)
    run = rig.play(LINES, COLLECT)
    assert (run.off, run.span_off, run.late) == (0, 0, 0)
    assert run.widths == {13 * CYCLES_PER_TICK}, "13 ticks, the least that last 1 µs"
    assert min(run.setups) == 63 * CYCLES_PER_TICK, "63 ticks, the least that last 5 µs"
    assert run.position == rig.count_steps()
    stamps = rig.wire().stamps
    rig.pico.exec("while pending(): app.cycle()")
    rig.pico.run(10_000)
    assert rig.wire().overruns == 0
    gaps = [after - before for before, after in zip(stamps, stamps[1:])]
    character = 10 * 1e9 / CYCLE_NS / BAUD
    assert min(gaps) == pytest.approx(character, rel=0.005), "as far apart as the baud rate says"
    assert rig.wire().drain() == b"n" * POINTS
    show(f"pulses at {mhz} MHz", f"{run.steps} steps, all where their words put them; interrupts leave {run.share_left():.0%}")


@pytest.mark.on_a_copy
@pytest.mark.xdist_group("pwm")
@MHZ
def test_time_and_pwm(pwm_rig, mhz):  # noqa: F811
    at_clock(pwm_rig, mhz, spindle=SPINDLE)
    pico = pwm_rig.pico
    wave, probe = pico.record_edges(PWM_PIN), pico.record_edges(PROBE_PIN)
    pico.exec(
        "from machine import Pin, Timer\n"
        "port.power(250)\n"
        f"probe, fired = Pin({PROBE_PIN}, Pin.OUT, value=0), []\n"
        "timer = Timer(mode=Timer.PERIODIC, period=3, callback=lambda _: fired.append(ticks_us()), hard=False)\n"
        "begun = ticks_us()\n"
        "probe(1)\n"
        "while ticks_diff(ticks_us(), begun) < 20_000: pass\n"
        "probe(0)\n"
        "timer.deinit()\n"
    )
    (rise, _), (fall, _) = probe[-2:]
    assert (fall - rise) / CYCLES_PER_US == pytest.approx(20_000, abs=60), "the microseconds of the firmware"
    fired = eval(pico.exec("print(fired)"))
    assert (fired[-1] - fired[0]) / (len(fired) - 1) == pytest.approx(3000, abs=40) and len(fired) in (6, 7)
    rises = [cycle for cycle, state in wave if state == 1]
    falls = [cycle for cycle, state in wave if state == 0 and cycle > rises[0]]
    assert len(rises) > 90, "of 20 ms at 5 kHz"
    assert {after - before for before, after in zip(rises, rises[1:])} == {200 * CYCLES_PER_US}
    assert (falls[0] - rises[0]) / CYCLES_PER_US == pytest.approx(50, abs=0.2), "a quarter of it"


@pytest.mark.slow
@pytest.mark.on_a_copy
@pytest.mark.xdist_group("timer")
@pytest.mark.parametrize("mhz", [125, 150, 200])
def test_the_timer_player(timer_rig, mhz):
    at_clock(timer_rig, mhz, player="timer")
    run = timer_rig.play([((600, 400, -300), 20_000)], COLLECT)
    jitter_us = [cycles / CYCLES_PER_US for cycles in run.lateness]
    assert run.late == 0 and run.position == timer_rig.count_steps() == [600, 400, -300]
    assert max(jitter_us) - min(jitter_us) < 3.2 and abs(run.span_off) / CYCLES_PER_US < 3.2
    assert min(run.widths) >= CYCLES_PER_US, "a pulse is never shorter than it has to be"


def router_at(mhz):
    return {**boards.load("router_3axis"), "clock_mhz": mhz}


@pytest.mark.parametrize("mhz", [pytest.param(150, marks=pytest.mark.slow), 200])
def test_a_machine_as_it_is_flashed(make_machine, mhz):
    machine = make_machine(router_at(mhz), trace=None)
    machine.run_until(lambda: b"unlock]\r\n" in machine.replies_so_far("serial"), 5000)
    assert system_clock.clock_of(machine.pico.chip).hz == mhz * 1_000_000
    machine.take("serial")
    machine.send(b"?", "serial")
    machine.run_until(lambda: b">" in machine.replies_so_far("serial"), 1000)  # loaded modules are put in their places first
    assert machine.take("serial").startswith(b"<Alarm|MPos:0.000,0.000,0.000|")
    console = machine.pico.console
    begun = list(machine.plant.position)
    console.take_output()
    console.send(b"$X\nG21G91F2400\nG1X1\n")
    machine.run_until(lambda: console.text.count(b"ok") == 3, 2000)
    machine.settle()
    moved = [after - start for after, start in zip(machine.plant.position, begun)]
    assert moved == [320, 0, 0] and not machine.plant.errors


def test_a_voltage_that_does_not_rise_leaves_all_safe(make_machine, monkeypatch):
    monkeypatch.setattr(system_clock, "_SETTLE_NS", 1e12)
    board = router_at(200)
    machine = make_machine(board, trace=None)
    pico = machine.pico
    driven = {entry["pin"]: entry.get("active", 1) for entry in [board["tool"], *board["outputs"]]}
    machine.run_until(lambda: b"does not rise" in pico.console.text, 5000)
    machine.run_ms(500)  # the file is written
    assert b"RuntimeError: clock_mhz: the core voltage does not rise to 1.15 V" in pico.console.text
    assert {pin: pico.pads.state_of(pin) for pin in driven} == {pin: 1 - active for pin, active in driven.items()}
    assert system_clock.clock_of(pico.chip).hz == 125_000_000
    assert "does not rise" in pico.exec("print(open('crash.txt').read())"), "the REPL answers"


# --- the emulator itself


def test_too_fast_for_the_voltage(uf2):
    pico = EmulatedPico(uf2=uf2).boot()
    with pytest.raises(Undervolted, match="200 MHz"):
        pico.exec("import machine; machine.freq(200_000_000)")


@pytest.mark.parametrize("native_loop", [pytest.param(True, marks=pytest.mark.slow), False])
def test_a_loop_takes_its_cycles(uf2, native_loop, monkeypatch):
    """Whatever the clock, and with either processor; flash is read at half the clock, or a fourth of a faster one."""
    if not native_loop:
        monkeypatch.setattr(native, "load_library", lambda: None)
    elif native.load_library() is None:
        pytest.skip("NOT TESTED: no C compiler")
    pico = EmulatedPico(uf2=uf2).boot()
    assert (pico.native_loop is not None) == native_loop
    pico.exec(RAISE)
    cycles, us = {}, {}
    for mhz in (125, 150, 200):
        us[mhz] = int(pico.exec(f"machine.freq({mhz}_000_000); print(took())"))
        assert pico.chip.ssi.read_uint32(FLASH_DIVIDER) == (2 if mhz == 125 else 4)
        cycles[mhz] = us[mhz] * mhz
    assert all(found == pytest.approx(cycles[125], rel=0.01) for found in cycles.values()), us
    assert int(pico.exec("machine.freq(125_000_000); print(took())")) == pytest.approx(us[125], abs=2)
    pico.exec("machine.freq(200_000_000)")
    pico.hard_reset()
    assert system_clock.clock_of(pico.chip).hz == 125_000_000


def test_a_miss_costs_what_flash_takes(uf2):
    """400 ns at 125 MHz, 667 at 150, 500 at 200: in cycles 50, 100, 100."""
    pico = EmulatedPico(uf2=uf2).boot()
    pico.exec(RAISE)
    cache = pico.charge_flash(50)
    for mhz, cost in ((125, 50), (150, 100), (200, 100)):
        pico.exec(f"machine.freq({mhz}_000_000)")
        assert (cache.miss_cycles, cache.state.miss_cycles) == (50, cost)
