"""`?` on the emulated Pico: its answer puts the feeder's call off, and no step is late by that."""

import pytest
from emulated import rig, uf2  # noqa: F401

from host_tools.bench.moving import _percentile_99
from host_tools.emulator import rows

LINES = [((9000, 7000, -5000), 100_000), ((-4000, 2000, 3000), 50_000)]
LATER = {  # the interrupt comes every 3 ms: in 2.7 ms once at most
    "made up for": "port.put_off(); sleep_us(2700); head = feeder.ring.head; port.catch_up(); made += feeder.ring.head != head",
    "never made up for": "port.put_off(); sleep_ms(6)",  # the second call of the interrupt makes words again, for example if the PC does not take the answer
    "nothing left out": "port.put_off(); port.catch_up()",
}
WITHIN_MS = 6  # 5 is what `make bench ARGS=streams` has to show; this is a stream of another length
LEAST_S = 7000


@pytest.mark.on_a_copy
@pytest.mark.xdist_group("rig")
@pytest.mark.parametrize("case", LATER)
def test_a_call_that_was_put_off_delays_no_step(rig, case):  # noqa: F811
    rig.pico.exec("made = 0\nfrom time import sleep_us")
    run = rig.play(LINES, loop=LATER[case])
    assert (run.late, run.off) == (0, 0)
    assert run.steps and run.turns > 10
    made = int(rig.pico.exec("print(made)"))
    assert made > run.turns // 2 if case == "made up for" else made == 0, (made, run.turns)


@pytest.mark.slow
def test_a_question_amid_packed_rows(uf2, monkeypatch, show):  # noqa: F811
    """At 125 MHz, over USB: the most that a link brings."""
    monkeypatch.setenv("PASSO_FLASH_MISS", "50")
    machine = rows.fast_laser(125)
    run = rows.measure_stream(machine, "usb", "packed", 1000, 4)
    p99_ms = _percentile_99(run["asked_ms"])
    show("`?` amid packed rows at 125 MHz", f"p99 {p99_ms:.1f} ms of {len(run['asked_ms'])}, {run['rate']:.0f} dots a second")
    assert (run["late"], run["stands"]) == (0, 0)
    assert run["rate"] >= LEAST_S and p99_ms < WITHIN_MS
