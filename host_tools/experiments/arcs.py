"""Arcs by radius and angle, as the mill of 2004 takes them: how far CORDIC's end lies from the true one, and the path from the circle."""

import random
from dataclasses import dataclass
from math import atan2, cos, degrees, hypot, pi, sin

from host_tools.experiments import charts
from host_tools.experiments.authors import without_figure
from host_tools.experiments.grbl_talk import ask_line, wait_up
from host_tools.experiments.places import BOARD, VIRTUAL, program_text
from host_tools.experiments.row import Outcome
from host_tools.language import _
from passo.motion.cordic import TURN

ENDS, LARGEST, SEED = 200, 48_000, 2004  # arcs of random radius, in steps, and angle
STEPS_MM = 80  # of mill_2004
START = 24_000, 16_000, -3000
FEED = 2400  # mm/min
MOST_DOTS = 300  # of an arc in the picture
ARCS = ((2, 360), (5, 45), (10, -135), (15, 270), (20, 90))  # radius in mm, degrees: counter-clockwise if positive


@dataclass
class Arc:
    """An arc that was walked. Steps; the centre is 0;0."""

    radius: float
    sweep_deg: float
    points: list  # its positions (x, y), the start first

    def end_error(self):
        """Return the distance from the last position to the true end, in steps."""
        x, y = self.points[0]
        angle = self.sweep_deg * pi / 180
        true = x * cos(angle) - y * sin(angle), x * sin(angle) + y * cos(angle)
        return hypot(self.points[-1][0] - true[0], self.points[-1][1] - true[1])

    def off_circle(self):
        """Return the distance of each position from the circle, in steps: outside is positive."""
        return [hypot(x, y) - self.radius for x, y in self.points]

    def angles_deg(self):
        """Return the degrees swept at each position."""
        swept = [0.0]
        for (x0, y0), (x1, y1) in zip(self.points, self.points[1:]):
            swept.append(swept[-1] + degrees(atan2(x0 * y1 - y0 * x1, x0 * x1 + y0 * y1)))
        return swept


def random_ends():
    """Return ENDS random [(radius in steps, angle in 2⁻³² turn)], up to a quarter of a turn to both sides, as the document allows."""
    chance = random.Random(SEED)
    return [(chance.randint(1, LARGEST), chance.randint(-TURN // 4, TURN // 4)) for _again in range(ENDS)]


def end_errors(place, ends):
    """Return two lists of distances from the true ends, in steps: by the document's CORDIC (section 2.7.3 of 2004), rounded to whole steps as motors
    make them, and by the firmware's."""
    if place.kind == VIRTUAL:
        from host_tools.experiments.board_cordic import document_end, firmware_end

        found = [(*document_end(radius, angle * 360 / TURN), *firmware_end(radius, angle)) for radius, angle in ends]
    else:
        chip = place.start_chip("mill_2004")
        chip.exec(program_text("board_cordic.py"))
        found = []
        for at in range(0, len(ends), 50):
            part = [(radius, angle, round(angle * 360 / TURN, 6)) for radius, angle in ends[at : at + 50]]
            said = chip.exec(f"for r, a, d in {part!r}: print(*document_end(r, d), *firmware_end(r, a))")
            found += [tuple(map(float, line.split())) for line in said.splitlines()]
    true = [(radius * cos(2 * pi * angle / TURN), radius * sin(2 * pi * angle / TURN)) for radius, angle in ends]
    document = [hypot(round(x) - tx, round(y) - ty) for (x, y, _a, _b), (tx, ty) in zip(found, true, strict=True)]
    return document, [hypot(x - tx, y - ty) for (_a, _b, x, y), (tx, ty) in zip(found, true, strict=True)]


def walk(place):
    """Return ARCS as the motors of a mill make them: a list of Arc."""
    machine = place.create_machine("mill_2004", start=START)
    try:
        wait_up(machine)
        for line in (b"$X\n", b"G91G21G17\n"):
            ask_line(machine, line)
        return [_walk_arc(machine, radius, sweep) for radius, sweep in ARCS]
    finally:
        machine.close()


def _walk_arc(machine, radius_mm, sweep):
    """Send one arc (mm, degrees) and return it as an Arc of the motors' steps. Raises Failure if it is refused."""
    before = len(machine.trace.rows())
    code = "G3" if sweep > 0 else "G2"
    ask_line(machine, f"{code} I{-radius_mm} J0 H{abs(sweep)} F{FEED}\n".encode())
    machine.settle()
    rows = machine.trace.rows()[before - 1 :]
    radius = radius_mm * STEPS_MM
    centre = rows[0][1] - radius, rows[0][2]
    return Arc(radius, sweep, [(x - centre[0], y - centre[1]) for _t, x, y, *_rest in rows])


def run(place):
    """Return the Outcome: ends by both CORDICs, and the path of ARCS except on a board."""
    ends = random_ends()
    document, firmware = end_errors(place, ends)
    outcome = Outcome(_("{} random arcs of up to {} steps' radius and a quarter of a turn; the true end by sine and cosine of 64 bits", ENDS, LARGEST))
    tells = without_figure("section 2.7.3")
    outcome.add_row(_("end by the document's 15 steps in floating point, off at most"), tells, max(document), _("steps"))
    outcome.add_row(_("end by the firmware's integer CORDIC, off at most"), tells, max(firmware), _("steps"))
    shown = {_("15 steps, floating point"): document, _("firmware, integers"): firmware}
    dots = {label: [(radius, off) for (radius, _angle), off in zip(ends, each)] for label, each in shown.items()}
    outcome.pictures.append((_("Distance from the true end, steps"), charts.draw_dots(dots, _("radius, steps"), _("steps"))))
    if place.kind != BOARD:
        _add_path(outcome, walk(place))
    return outcome


def _add_path(outcome, arcs):
    """Add the rows and the picture of the arcs that motors made."""
    outcome.how += "; " + _("then {} arcs of a mill, every step on its pins", len(arcs))
    circle = without_figure("section 2.7.2")
    for arc in arcs:
        named = _("R {} mm, {}°", round(arc.radius / STEPS_MM), arc.sweep_deg)
        outcome.add_row(_("{}: off the circle at most", named), circle, max(map(abs, arc.off_circle())), _("steps"))
        outcome.add_row(_("{}: end off the true one", named), without_figure("section 2.7.3"), arc.end_error(), _("steps"))
    groups = {}
    for arc in arcs:
        every = max(1, len(arc.points) // MOST_DOTS)
        groups[_("R {} mm, {}°", round(arc.radius / STEPS_MM), arc.sweep_deg)] = list(zip(arc.angles_deg(), arc.off_circle()))[::every]
    outcome.pictures.append((_("Distance from the circle on the way, steps"), charts.draw_dots(groups, _("degrees"), _("steps"))))
