"""Pulses of the emulated Pico from the edges on its pins, against the words the same firmware makes under CPython, while
packets arrive and garbage is collected without pause."""

import itertools

import pytest
from emulated import rig, timer_rig, uf2  # noqa: F401

from host_tools.emulator.halting import INTERRUPT_PIN, amid_start
from host_tools.emulator.rig import Rig, router_board
from host_tools.emulator.traffic import move_packets
from host_tools.sim.decoders import Pbl3770a

pytestmark = [pytest.mark.on_a_copy]
ONE_AXIS_HZ = (10_000, 50_000, 100_000, 200_000, 250_000, 480_000)
THREE_AXES_HZ = (10_000, 100_000, 400_000, 480_000)
LINE_S = 0.012
COLLECT = "gc.collect()"
CYCLE_NS = 8
BAUD = 115_200
FLASH_MISS = 50  # cycles
POINTS = 100


def ticks_of_us(us):
    """The least that last `us`."""
    return -(-us * 1000 // 80)


def back_and_forth(rates, axes):
    lines, sign = [], 1
    for hz in rates:
        steps = int(hz * LINE_S)
        lines.append((tuple(sign * steps * (axis < axes) for axis in range(3)), hz))
        sign = -sign
    return lines


@pytest.mark.xdist_group("rig")
@pytest.mark.parametrize("axes, rates", [(1, ONE_AXIS_HZ), (3, THREE_AXES_HZ)])
def test_every_interval_is_its_word(rig, axes, rates, show):
    rig.wire().feed(move_packets(POINTS), BAUD)
    run = rig.play(back_and_forth(rates, axes), COLLECT)
    assert (run.off, run.span_off, run.late) == (0, 0, 0)
    assert run.widths == {13 * 80 // CYCLE_NS}, "13 ticks, the least that last 1 µs"
    assert min(run.setups) == 63 * 80 // CYCLE_NS, "63 ticks, the least that last 5 µs"
    assert run.position == rig.count_steps()
    rig.pico.exec("while pending(): app.cycle()")
    rig.pico.run(10_000)  # the last answers are on the wire
    assert rig.wire().drain() == b"n" * POINTS and rig.wire().overruns == 0
    show(
        f"pulses of {axes} axes at {', '.join(str(hz // 1000) for hz in rates)} kHz",
        f"{run.steps} steps, all where their words put them; 0 words late; interrupts leave {run.share_left():.0%}",
    )


@pytest.mark.xdist_group("rig")
@pytest.mark.parametrize("axes, hz", [(1, 480_000), (3, 480_000)])
def test_every_interval_is_its_word_with_the_flash_cache(rig, axes, hz, show):
    """From 10 kHz; each miss costs what it does on a Pico."""
    cache = rig.pico.charge_flash(FLASH_MISS)
    before = cache.misses
    rig.wire().feed(move_packets(POINTS), BAUD)
    run = rig.play(back_and_forth((10_000, hz), axes), COLLECT)
    assert (run.off, run.span_off, run.late) == (0, 0, 0)
    assert cache.misses - before > 1000 and run.position == rig.count_steps()
    show(f"pulses of {axes} axes at {hz // 1000} kHz, flash cache", f"0 words late; interrupts leave {run.share_left():.0%}")


@pytest.mark.xdist_group("rig")
@pytest.mark.parametrize("axes, hz", [(1, 480_000), (3, 400_000)])
def test_from_rest_at_full_rate(rig, axes, hz):
    run = rig.play([((12000, 12000 * (axes > 1), -12000 * (axes > 1)), hz)], COLLECT)
    assert (run.off, run.span_off, run.late) == (0, 0, 0)


@pytest.mark.xdist_group("rig")
@pytest.mark.parametrize(
    "pulse_us, setup_us, step_active, reverse",
    [(1, 0, 1, False), (2, 10, 0, True), (5, 2, 1, True), (5, 0, 0, False)],
)
def test_pulse_width_setup_and_polarity_are_those_of_the_board_file(rig, pulse_us, setup_us, step_active, reverse):
    board = router_board(3, drive={"kind": "step_dir", "pulse_us": pulse_us, "setup_us": setup_us, "step_active": step_active})
    for axis in board["axes"]:
        axis["reversed"] = reverse
    rig.load_board(board)
    run = rig.play([((300, 200, -100), 50_000), ((-300, 100, 100), 50_000)], COLLECT)
    assert (run.off, run.span_off, run.late) == (0, 0, 0)
    assert run.widths == {ticks_of_us(pulse_us) * 80 // CYCLE_NS}
    if setup_us:
        least = max(ticks_of_us(setup_us), 2 * ticks_of_us(pulse_us))  # no word is shorter than its pulse twice
        assert min(run.setups) == least * 80 // CYCLE_NS
    assert run.position == rig.count_steps() == [0, 300, 0]


@pytest.mark.xdist_group("rig")
@pytest.mark.parametrize("hz, missed", [pytest.param(100_000, 0, marks=pytest.mark.slow), (400_000, 0), (390_000, FLASH_MISS)])
def test_four_axes(rig, hz, missed, show):
    """`missed`: cycles of a miss of the flash cache. With these 400 kHz is kept or not by where the code happens to lie: with some
    layouts the player waits once."""
    rig.load_board(router_board(4))
    if missed:
        rig.pico.charge_flash(missed)
    run = rig.play([((12000, 9000, -6000, 3330), hz), ((-12000, 0, 6000, 10000), hz)], COLLECT)
    assert (run.off, run.span_off, run.late) == (0, 0, 0)
    assert run.position == rig.count_steps() == [0, 9000, 0, 13330]
    show(f"four axes at {hz // 1000} kHz, {missed} cycles a miss", f"0 words late; interrupts leave {run.share_left():.0%}")


@pytest.mark.xdist_group("rig")
@pytest.mark.parametrize("mode", ["half", "full", "eighth"])
def test_two_motors_with_two_winding_chips_each(uf2, mode):  # noqa: F811
    """Thirteen pins of one word. A motor follows the currents on them to the same position."""
    board = router_board(2, drive={"kind": "pbl3770a", "mode": mode}, outputs=[], tool={"pin": 14})
    for axis, first in zip(board["axes"], (2, 8)):
        axis["pins"] = list(range(first, first + 6))
    rig = Rig(board, uf2)  # whose build has this drive
    run = rig.play([((400, -300), 20_000), ((-100, 300), 5000)], COLLECT)
    assert run.off == run.late == 0 and run.steps == 400 + 300
    assert run.position == turned(rig.edges, mode) == [300, 0]


def turned(edges, mode):
    """Steps of two motors by the edges of their twelve pins."""
    from passo.options.drive_pbl3770a import drive as pbl3770a

    errors = []
    motors = [Pbl3770a(mode, shift, 0, lambda *error: errors.append(error)) for shift in (0, 6)]
    levels, places = pbl3770a.OFF * 0b1000001, [0, 0]
    edges = sorted((cycle, bit, state) for bit, log in enumerate(edges[:12]) for cycle, state in log)
    for cycle, together in itertools.groupby(edges, key=lambda edge: edge[0]):
        before = levels
        for _, bit, state in together:
            levels = levels & ~(1 << bit) | state << bit
        places = [place + motor.decode(cycle, levels, levels ^ before) for place, motor in zip(places, motors)]
    assert errors == []
    return places


@pytest.mark.xdist_group("rig")
def test_an_uneven_line_keeps_its_rate(rig):
    """100 003 steps a second are no whole number of ticks apart."""
    run = rig.play([((2000, 1234, -777), 100_003)], COLLECT)
    assert (run.off, run.span_off, run.late) == (0, 0, 0)
    first = [cycle for cycle, state in rig.step_edges[0] if state == 1][100:]  # by then the delay of DIR's set-up time is made up
    rate = (len(first) - 1) / (first[-1] - first[0]) * 125e6
    assert rate == pytest.approx(100_003, rel=100e-6)


SLOW = """
def slowly(played, lead_ticks, fill=feeder.fill, slow=[True], ticks_us=ticks_us, ticks_diff=ticks_diff):
    amid = fill(played, lead_ticks)
    if slow[0] and played > 300:
        slow[0] = False
        begun = ticks_us()
        while ticks_diff(ticks_us(), begun) < 20_000:
            pass
    return amid
feeder.fill = slowly
"""  # no globals: the interrupt may come while the REPL's program makes one


@pytest.mark.xdist_group("rig")
def test_words_that_take_too_long_to_make_are_counted(rig):
    rig.pico.exec(SLOW)
    run = rig.play([((1500, 0, 0), 50_000)])
    steps = [cycle for cycle, state in rig.step_edges[0] if state == 1]
    gaps = sum(after - before > 1.5 * 125e6 / 50_000 for before, after in itertools.pairwise(steps))
    assert run.late == gaps and gaps in (1, 2) and run.span_off > 5 * 125_000, "12 ms of words for a pause of 20 ms"
    assert run.position == rig.count_steps() == [1500, 0, 0]


@pytest.mark.xdist_group("timer")
@pytest.mark.on_a_copy
@pytest.mark.parametrize("miss_cycles", [0, 50])
def test_the_timer_player_keeps_time(timer_rig, miss_cycles, show):
    hz = 36_000
    timer_rig.pico.flash_cache.miss_cycles = miss_cycles
    run = timer_rig.play([((600, 400, -300), hz)], COLLECT)
    jitter_us = [cycles / 125 for cycles in run.lateness]
    assert run.late == 0 and run.position == timer_rig.count_steps() == [600, 400, -300]
    assert max(jitter_us) - min(jitter_us) < 3.2, "the flash cache modelled too"
    assert abs(run.span_off) / 125 < 3.2, "it does not drift"
    assert min(run.widths) >= 125 and max(run.widths) < 3 * 125, "pulses of 1 µs"
    show(f"timer player at 36 kHz, {miss_cycles} cycles a miss", f"lateness within {max(jitter_us) - min(jitter_us):.1f} µs over {run.steps} steps")


@pytest.mark.xdist_group("timer")
def test_a_halt_amid_the_start_of_the_timer_player(timer_rig):
    for before_us, steps, reported in amid_start(timer_rig, INTERRUPT_PIN, (600, 400, -300), 20_000, range(50, 72, 2)):
        assert not steps and reported == [0, 0, 0], before_us
