"""Pulse rates: the highest at which every edge lies where its word puts it and no word is late, of PIO and of the timer's interrupt.

The emulated Pico keeps each edge of each pin; a board looks at its own by a spare state machine, as `passo prove` does. The virtual machine has no
highest rate: it shows the documents' rates instead, by its motors.
"""

from host_tools.experiments import charts
from host_tools.experiments.authors import author_figure
from host_tools.experiments.places import BOARD, VIRTUAL
from host_tools.experiments.row import Outcome
from host_tools.language import _
from passo.steps.word import TICKS_PER_S

PIO_KHZ = (10, 50, 100, 200, 400, 480)
TIMER_KHZ = (10, 25, 50, 80, 120)
AXES = 3
KIT_UP_MS, KIT_MS, KIT_STEPS = 3000, 1500, 200
ON_TIME_NS = 80  # one tick
TIMER_LATE_US = 5  # an edge of the timer's interrupt


def measure_clean_rates(place):
    """Return ({kHz: True if clean} by PIO, three axes together; the same by the timer, one axis; {} on a board)."""
    if place.kind == BOARD:
        return measure_on_board(place), {}
    from host_tools.emulator.copies import on_a_copy
    from host_tools.emulator.rig import Rig, router_board

    pio, timer = Rig(router_board(AXES)), Rig(router_board(AXES, player="timer"))
    return (
        {khz: on_a_copy(lambda: _pio_is_clean(pio, khz)) for khz in PIO_KHZ},
        {khz: on_a_copy(lambda: _timer_is_clean(timer, khz)) for khz in TIMER_KHZ},
    )


def _pio_is_clean(rig, khz):
    """True if at this rate no word is late, and every edge is within 80 ns of its word."""
    from host_tools.bench.pico import COLLECT, constant_lines
    from host_tools.emulator.cycles import CYCLE_NS

    run = rig.play(constant_lines(khz * 1000, AXES), COLLECT)
    return run.late == 0 and run.off * CYCLE_NS <= ON_TIME_NS


def _timer_is_clean(rig, khz):
    """True if at this rate no word is late, and edges are within 5 µs, or a step's time if that is less."""
    from host_tools.bench.pico import COLLECT, constant_lines
    from host_tools.emulator.cycles import CYCLES_PER_US

    run = rig.play(constant_lines(khz * 1000, 1), COLLECT)
    late_us = (max(run.lateness) - min(run.lateness)) / CYCLES_PER_US
    return run.late == 0 and late_us < min(TIMER_LATE_US, 1000 / khz)


def why_left_out(raw):
    """Return the reason why the rates of a board of this board file are not measured; "" if they are."""
    if raw["drive"]["kind"] != "step_dir" or raw.get("player", "pio") == "timer":
        return _("its board file has coils or the timer player: rates are for STEP and DIR by PIO")
    return ""


def measure_on_board(place):
    """Return {kHz: True if clean} of the board's own pins, by its spare state machine; the motors' current stays off."""
    from host_tools.prove.pins import FAST, FAST_STEPS, play_lines
    from host_tools.prove.proof import Proof

    raw = place.board_table()
    changes = {"axes": [dict(axis, **FAST) for axis in raw["axes"]], "drive": dict(raw["drive"], pulse_us=1)}
    proof, found = Proof(place.connection(), raw, True), {}
    for khz in PIO_KHZ:
        lines = [([FAST_STEPS] * len(raw["axes"]), FAST_STEPS * TICKS_PER_S // (khz * 1000))]
        seen, late, _shape, _records = play_lines(proof, changes, lines)
        found[khz] = seen.same and late == 0 and seen.off_ns <= ON_TIME_NS
    return found


def kit_rate(place):
    """Return the steps a second of the kit's first motor at its fastest speed, by its plant."""
    machine = place.create_machine("two_motor_kit")
    try:
        machine.run_ms(100 if place.kind == VIRTUAL else KIT_UP_MS)
        machine.send(b"A\x01C")
        machine.run_ms(KIT_MS)
        rows = machine.trace.rows()[-KIT_STEPS - 1 :]
        return KIT_STEPS / (rows[-1][0] - rows[0][0]) * 1e6
    finally:
        machine.close()


def run(place):
    """Return the Outcome: the kit's rate, and the highest clean rates of PIO and timer."""
    outcome = Outcome("")
    if place.kind != BOARD:
        outcome.how = _("the kit's motor by its coils")
        outcome.add_row(_("kit, speed 1"), author_figure("pause of the kit"), kit_rate(place), _("steps/s"))
    if place.kind != VIRTUAL:
        _add_fastest(place, outcome)
    return outcome


def _add_fastest(place, outcome):
    """Add the highest clean rates, in kHz, and their picture."""
    by_pio, by_timer = measure_clean_rates(place)
    how = _("steps at a constant rate; clean: every edge within {} ns of its word by PIO, within {} µs by the timer, no word late", ON_TIME_NS, TIMER_LATE_US)
    outcome.how = "; ".join(filter(None, (outcome.how, how)))
    axes = len(place.board_table()["axes"]) if place.kind == BOARD else AXES
    rows = ((_("PIO, {} axes together: highest clean rate", axes), by_pio), (_("timer's interrupt, one axis: highest clean rate"), by_timer))
    for label, found in rows:
        if found:
            tried = _("tried: {} kHz", ", ".join(map(str, found)))
            outcome.add_row(label, author_figure("pulses of the drawing"), max((khz for khz, right in found.items() if right), default=0), "kHz", tried)
    names = [_("document, figure 10"), "PIO", _("timer")]
    highest = [author_figure("pulses of the drawing").value, *(max((khz for khz, right in found.items() if right), default=None) for found in (by_pio, by_timer))]
    outcome.pictures.append((_("Highest clean rate, kHz"), charts.draw_bars(names, {"kHz": highest}, "kHz")))
