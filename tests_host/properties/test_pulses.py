"""The cuts of LPTControl's document at their full size."""

import pytest

import check_pulses
from host_tools.programs import pulse_shapes
from lpt import Lpt


@pytest.mark.parametrize("shape", pulse_shapes.SHAPES)
def test_cuts_of_the_document(shape, show):
    """At their full size: closed, every step where it should be, diagonals at the same speed along the path."""
    text = pulse_shapes.shape_text(shape, 80, 2000)
    machine = Lpt()
    machine.load(text)
    machine.tell("run")
    machine.until("end", turns=4_000_000)
    assert machine.picture() == check_pulses.places_of(check_pulses.codes_of(text))
    assert machine.world.place == [0, 0, 0] and machine.world.tool == 0
    assert machine.app.controller.machine.log.entries == []
    rows = machine.world.path
    periods = {True: [], False: []}
    for before, after, later in zip(rows, rows[1:], rows[2:]):
        made = [to - at for at, to in zip(before[1:4], after[1:4])]
        if made == [to - at for at, to in zip(after[1:4], later[1:4])]:
            periods[bool(made[0] and made[1])].append(later[0] - after[0])
    for diagonal, period_us in ((False, 375), (True, 530)):  # 12.5 µm and √2 times that, at 2000 mm/min
        some = sorted(periods[diagonal])
        if some:
            # Behind a corner an interval is shorter or longer by the change of direction, 20 µs.
            assert some[100] >= period_us * 25 // 2 and some[-100] <= period_us * 25 // 2 + 1
            assert min(some) >= period_us * 25 // 2 - 250 and max(some) <= period_us * 25 // 2 + 251
    show(f"{shape} as a pulse file", f"{len(rows)} steps in {(rows[-1][0] - rows[0][0]) / 12.5e6:.3f} s")
