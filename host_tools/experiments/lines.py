"""Integer lines against floating-point lines: the processor's time alone, on the five objects of table 8."""

from array import array
from statistics import fmean

from host_tools.drawings.objects import objects
from host_tools.experiments import board_lines, charts
from host_tools.experiments.authors import author_figure, without_figure
from host_tools.experiments.places import VIRTUAL, program_text
from host_tools.experiments.row import Outcome, percent_better
from host_tools.language import N_, _

LONGEST = 1024  # steps of a line
REPEATS = 7  # on a PC, of which the shortest counts
# Each object once with each line. An interpreter that has never run a function before allocates: once in vain.
ON_THE_CHIP = """
from array import array
import gc, machine
OUT = array("I", bytearray(4 * {longest}))
for line in (integer_line, float_line):
    time_lines(line, [(0, 0), (9, 4)], OUT)
"""
TIMES = """
gc.collect()
print(*time_lines(integer_line, {points!r}, OUT), *time_lines(float_line, {points!r}, OUT))
"""
CLOCK = "print(machine.freq())"
WORDS = {"square": N_("square"), "triangle": N_("triangle"), "spiral": N_("spiral, 25 points"), "text": N_("text, 74 points"), "circle": N_("circle, 50 points"), "mean": N_("mean")}


def points_of():
    """Return {name: [(x, y), …]} of the five objects of table 8, in steps."""
    return {name: [(x, y) for _down, x, y in each] for name, each in objects().items()}


def measure_lines(place):
    """Return {name: (microseconds of the integer line, its steps, those of the float line, its steps)}, and the clock in MHz; 0 on a PC."""
    if place.kind == VIRTUAL:
        return {name: _shortest_times(points) for name, points in points_of().items()}, 0
    chip = place.start_chip("plotter_2014")
    chip.exec(program_text("board_lines.py"))
    chip.exec(ON_THE_CHIP.format(longest=LONGEST))
    times = {name: tuple(map(int, chip.exec(TIMES.format(points=points)).split())) for name, points in points_of().items()}
    return times, int(chip.exec(CLOCK)) / 1e6


def _shortest_times(points):
    """Return the shortest of REPEATS runs on this PC: (microseconds, steps) of both lines."""
    out = array("I", bytearray(4 * LONGEST))
    found = []
    for line in (board_lines.integer_line, board_lines.float_line):
        found += min(board_lines.time_lines(line, points, out) for _again in range(REPEATS))
    return tuple(found)


def run(place):
    """Return the Outcome: by how many percent integer lines are quicker than floating-point lines, alone."""
    times, mhz = measure_lines(place)
    if mhz:
        how = _("both lines in MicroPython on the chip, floats in software, no motor waits; by the chip's microseconds at {} MHz", round(mhz))
    else:
        how = _("both lines in Python on this PC, no motor waits, the shortest of {} runs: a ratio, not a time of a machine", REPEATS)
    outcome = Outcome(how)
    gains = {name: percent_better(float_us, integer_us) for name, (integer_us, _a, float_us, _b) in times.items()}
    gains["mean"] = percent_better(fmean(row[2] for row in times.values()), fmean(row[0] for row in times.values()))
    for name, gain in gains.items():
        outcome.add_row(_("integer line better by: {}", _(WORDS[name])), author_figure(f"{name} better"), gain, "%")
    for label, at in ((_("integer line, a step"), 0), (_("floating-point line, a step"), 2)):
        each = sum(row[at] for row in times.values()) / sum(row[at + 1] for row in times.values())
        unit, value = (_("cycles"), each * mhz) if mhz else ("µs", each)
        outcome.add_row(label, without_figure("table 8"), value, unit)
    names = [_(WORDS[name]) for name in times]
    bars = {_("integer"): [row[0] / 1000 for row in times.values()], _("floating point"): [row[2] / 1000 for row in times.values()]}
    outcome.pictures.append((_("Computing an object, ms"), charts.draw_bars(names, bars, "ms")))
    return outcome
