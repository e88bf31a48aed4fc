"""Drawing times at the motors' pace, table 8 and figure 48: each step waits twice for SPEED 1000, as the table of 2014 did.

On a chip the two lines of 2014 take turns with the waits, so that what they compute adds to the drawing time. The virtual machine and the emulated Pico also
draw the objects as Passo does, from the first packet to DONE: it computes ahead, and only the pace is left.
"""

from statistics import fmean

from host_tools.experiments import charts
from host_tools.experiments.authors import author_figure
from host_tools.experiments.lines import LONGEST, ON_THE_CHIP, WORDS, points_of
from host_tools.experiments.places import BOARD, VIRTUAL, program_text
from host_tools.experiments.row import Outcome, percent_better
from host_tools.failure import Failure
from host_tools.language import _
from passo.protocols.plotter.host import COMMANDS, packet

SPEED = 1000  # of figure 48: a half period in microseconds
PACED = "gc.collect()\nprint(time_paced(integer_line, {points!r}, OUT, {half_us}), time_paced(float_line, {points!r}, OUT, {half_us}))"
LOG = [(False, 644, 314), (True, 644, 454), (True, 884, 454), (True, 884, 314), (True, 644, 314)]  # the square of figure 48
MOST_MS = 120_000


def run(place):
    """Return the Outcome: times of both lines at the motors' pace on a chip, and of Passo on a virtual or emulated machine."""
    outcome = Outcome(_how_text(place))
    paced = {} if place.kind == VIRTUAL else measure_paced(place)
    drawn = {} if place.kind == BOARD else draw_objects(place)
    for name in points_of():
        label = _(WORDS[name])
        if name in paced:
            integer_s, float_s = paced[name]
            outcome.add_row(_("{}, integer line", label), author_figure(f"{name} integer"), integer_s, "s")
            outcome.add_row(_("{}, floating-point line", label), author_figure(f"{name} float"), float_s, "s")
            outcome.add_row(_("{}, integer line better by", label), author_figure(f"{name} better"), percent_better(float_s, integer_s), "%")
        if name in drawn:
            outcome.add_row(_("{}, drawn by Passo", label), author_figure(f"{name} integer"), drawn[name], "s")
    if paced:
        gain = percent_better(fmean(row[1] for row in paced.values()), fmean(row[0] for row in paced.values()))
        outcome.add_row(_("mean, integer line better by"), author_figure("mean better"), gain, "%")
    if drawn:
        outcome.add_row(_("square of the log, first packet to DONE"), author_figure("square of the log"), drawn["log"], "s")
    _add_picture(outcome, paced, drawn)
    return outcome


def _how_text(place):
    """Return the way of measuring at this place, as clauses of a sentence."""
    chip = _("each line computes a step's pins and waits {} µs twice a step, without pins, in MicroPython on the chip", SPEED)
    passo = _("Passo draws the same objects from packets, from the first byte to DONE, the pen's solenoid included")
    sizes = _("the document shows its objects as pictures without sizes: these are of the same kinds and point counts, so compare percentages, not seconds")
    return "; ".join([each for each, there in ((chip, place.kind != VIRTUAL), (passo, place.kind != BOARD), (sizes, True)) if there])


def measure_paced(place):
    """Return {name of an object: (seconds of the integer line, of the float line)}."""
    chip = place.start_chip("plotter_2014")
    chip.exec(program_text("board_lines.py"))
    chip.exec(ON_THE_CHIP.format(longest=LONGEST))
    found = {}
    for name, points in points_of().items():
        integer_us, float_us = chip.exec(PACED.format(points=[(0, 0), *points], half_us=SPEED)).split()
        found[name] = int(integer_us) / 1e6, int(float_us) / 1e6
    return found


def draw_objects(place):
    """Return {name: seconds from an object's first packet to DONE}; "log" is the square of figure 48. Each begins at 0;0."""
    from host_tools.drawings.objects import objects

    machine = place.create_machine("plotter_2014", start=(60, 40), trace=None)
    try:
        _send_packet(machine, "REQUEST", b"k")
        _send_packet(machine, "ORIGIN", b"o")
        _send_packet(machine, "SPEED", b"s", SPEED)
        return {name: _draw_object(machine, points) for name, points in {"log": LOG, **objects()}.items()}
    finally:
        machine.close()


def _draw_object(machine, points):
    """Draw an object, return the seconds from its first packet to DONE, and go back to 0;0."""
    begun = machine.now_ms()
    for down, x, y in points:
        _send_packet(machine, "LINE" if down else "MOVE", b"n", x, y)
    _send_packet(machine, "END", b"d")
    took_s = (machine.now_ms() - begun) / 1000
    _send_packet(machine, "MOVE", b"n", 0, 0)
    _send_packet(machine, "END", b"d")
    return took_s


def _send_packet(machine, command, answer, x=0, y=0):
    """Send a packet and wait for its answer, a byte. Raises TimeoutError without an answer, Failure for another one."""
    said = machine.ask(packet(COMMANDS[command], x, y), limit_ms=MOST_MS)
    if said != answer:
        raise Failure("{!r} was answered by {!r}", f"{command} {x} {y}", said)


def _add_picture(outcome, paced, drawn):
    """Add the picture of all drawing times, in seconds."""
    names = list(points_of())
    groups = {_("the document, integer"): [author_figure(f"{name} integer").value for name in names]}
    if paced:
        groups[_("integer")] = [paced[name][0] for name in names]
        groups[_("floating point")] = [paced[name][1] for name in names]
    if drawn:
        groups[_("Passo")] = [drawn[name] for name in names]
    outcome.pictures.append((_("Drawing an object, s"), charts.draw_bars([_(WORDS[name]) for name in names], groups, "s")))


