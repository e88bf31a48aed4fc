"""Table 1 of 2020: strokes of 10 to 100 mm at 60 cm/min on both axes, and the wait from a move's last byte to its first step.

The document measured strokes of a pen with a calliper, with 48 and 83 steps/mm; here the motors' steps are counted and divided by the same figures. So a
difference of the document's is its steps/mm or its mechanics, not its counting.
"""

from dataclasses import dataclass

from host_tools.experiments import charts
from host_tools.experiments.authors import author_figure
from host_tools.experiments.places import VIRTUAL
from host_tools.experiments.row import Outcome, figure_text
from host_tools.language import _
from passo.protocols.torch import protocol as torch

STEPS_MM = {"x": 48, "y": 83}
LENGTHS_MM = (10, 20, 50, 100)
MM_S = 10  # 60 cm/min
BYTE_MS = 10 / 115.2
UP_MS, CONNECT_MS = 4000, 100


@dataclass
class Stroke:
    """A stroke as the motor made it."""

    axis: str
    length: int  # mm asked for
    made: float  # mm, by the motor's steps
    wait_s: float  # from the last byte to the first step
    mm_s: float  # from the first step to the last


def draw_strokes(place):
    """Draw the strokes at a place, and go back after each; return them as Stroke, measured by the plant's motors."""
    machine = place.create_machine("torch_manipulator")
    try:
        machine.run_ms(CONNECT_MS if place.kind == VIRTUAL else UP_MS)
        machine.send(torch.frame("CONNECT"))
        machine.run_ms(CONNECT_MS)
        return [_draw_stroke(machine, axis, length, place.kind) for axis in STEPS_MM for length in LENGTHS_MM]
    finally:
        machine.close()


def _draw_stroke(machine, axis, length, kind):
    """Draw a stroke of `length` mm and go back; return its length, wait and speed."""
    steps, rate = length * STEPS_MM[axis], MM_S * STEPS_MM[axis]
    column = 1 + "xy".index(axis)
    known = len(machine.trace.rows())
    before = machine.trace.rows()[-1][column]
    sent_ms = machine.now_ms()
    _send_move(machine, axis, steps, rate, length)
    rows = [row for row in machine.trace.rows()[known:] if row[column] != before]
    wire_ms = 0 if kind == VIRTUAL else len(torch.move(0, 1, 0, 1)) * BYTE_MS
    wait_s = (rows[0][0] / 1000 - sent_ms - wire_ms) / 1000
    made = abs(rows[-1][column] - before) / STEPS_MM[axis]
    _send_move(machine, axis, steps, -rate, length)
    return Stroke(axis, length, made, wait_s, (len(rows) - 1) / STEPS_MM[axis] / (rows[-1][0] - rows[0][0]) * 1e6)


def _send_move(machine, axis, steps, rate, length):
    """Send a move of one axis, `steps` at `rate` steps/s, and wait until it has ended."""
    x, y = ((steps, rate), (0, 1)) if axis == "x" else ((0, 1), (steps, rate))
    machine.send(torch.move(*x, *y))
    machine.run_ms(1000 * length / MM_S + CONNECT_MS)


def run(place):
    """Return the Outcome: lengths and speeds of the strokes, and the wait before them on an emulated Pico."""
    strokes = draw_strokes(place)
    outcome = Outcome(_("the motors' steps, counted and divided by the document's 48 and 83 steps/mm; on paper measure with a calliper, and give the lengths to passo calibrate"))
    for each in strokes:
        told = _("at {} mm/min", figure_text(60 * each.mm_s))
        outcome.add_row(_("{}, {} mm asked for", each.axis.upper(), each.length), author_figure(f"{each.axis} {each.length}"), each.made, "mm", told)
    if place.kind != VIRTUAL:  # which computes in no time
        outcome.add_row(_("from a move's last byte to its first step, at most"), author_figure("click to motion"), max(each.wait_s for each in strokes), "s")
    names = [f"{each.axis.upper()} {each.length} mm" for each in strokes]
    errors = {
        _("document"): [author_figure(f"{each.axis} {each.length}").value - each.length for each in strokes],
        _("ours, steps counted"): [each.made - each.length for each in strokes],
    }
    outcome.pictures.append((_("Length made less the length asked for, mm"), charts.draw_bars(names, errors, "mm")))
    return outcome
