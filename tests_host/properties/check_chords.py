"""Arcs whose axes differ in steps/mm, on the router: Z has 400 steps/mm, X and Y 320. And helices too steep for a circle."""

from math import atan2, pi, sqrt

from router import Machine

STEPS_MM = (320, 320, 400)
TICKS_PER_S = 12_500_000
CASES = {
    "check_any_arc": (
        ("radius", 1, 3000), ("start", 0, 359), ("sweep", 1, 360), ("clockwise", 0, 1), ("plane", 0, 1), ("feed", 60, 1500),
    ),
}
RUNS = {"check_any_arc": 8}
NOT_QUICK = ("check_long_arcs_need_no_room_for_all",)


def machine_at_rest():
    machine = Machine()
    machine.do("$X", "$21=0", "G21 G90 G94")
    return machine


def run_arc(machine, *lines):
    """[(tick, x, y, z in mm)] of every step from here, the start first."""
    world = machine.world
    begin = world.place[:]
    world.path = []
    machine.do(*lines)
    machine.settle()
    path, world.path = world.path, None
    steps = [(step[0], [(step[1 + axis] - begin[axis]) / STEPS_MM[axis] for axis in range(3)]) for step in path]
    return steps, [world.place[axis] - begin[axis] for axis in range(3)]


def hold_arc(steps, a, b, centre, radius):
    """Hold every step within a quarter of a step of the circle, plus the rounding: of the centre (the circle still begins at the start, so it is off by up
    to twice as much on the other side), of the chords' ends, of the lines that are walked. Returns the turns made.
    """
    turned = 0.0
    before = atan2(-centre[1], -centre[0])
    for _, place in steps:
        u, w = place[a] - centre[0], place[b] - centre[1]
        assert abs(sqrt(u * u + w * w) - radius) <= (0.25 + 2 * 0.71 + 0.5 + 0.71) / 320
        angle = atan2(w, u)
        turned += (angle - before + 3 * pi) % (2 * pi) - pi
        before = angle
    return turned / (2 * pi)


def hold_speed(steps, feed):
    """The path's speed between steps 40 ms apart, ramps of 250 mm/s² left out."""
    mm_s = feed / 60
    away = int(mm_s / 150 * TICKS_PER_S) + TICKS_PER_S // 20
    middle = [step for step in steps if steps[0][0] + away < step[0] < steps[-1][0] - away]
    window = TICKS_PER_S // 25
    first = 0
    speeds = []
    for last in range(len(middle)):
        if middle[last][0] - middle[first][0] >= window:
            by = [to - at for to, at in zip(middle[last][1], middle[first][1])]
            speeds.append(sqrt(sum([part * part for part in by])) / (middle[last][0] - middle[first][0]) * TICKS_PER_S)
            first = last
    for speed in speeds:
        grain = 3.5 / 320 / (mm_s / 25)  # of the two places, in steps
        assert abs(speed / mm_s - 1) <= 0.02 + grain, (speed, mm_s)
    return len(speeds)


def check_the_arc_of_cncjs():
    """shared/data's cncjs_arc-yz-plane.gcode, which a machine with axes of different steps/mm could not run."""
    machine = machine_at_rest()
    machine.do("G19", "G92 Z0", "G1 Y0Z20 F200")
    machine.settle()
    steps, end = run_arc(machine, "G2 Y20Z0 J0 K-20.0")
    assert end == [0, 20 * 320, -20 * 400]
    turned = hold_arc(steps, 1, 2, (0, -20), 20)
    assert abs(turned + 0.25) < 0.001
    assert hold_speed(steps, 200) > 50


def check_long_arcs_need_no_room_for_all():
    """Ten turns on a large radius are some thousand chords; lines behind them wait, and a hold and its end lose nothing."""
    machine = machine_at_rest()
    machine.put("G18 G91\nG2 X0 Z0 I-15 K0 P10 F5000\nG1 X-1 F1000\n")
    machine.cycles(300)
    assert machine.controller.queue.room() == 0
    machine.put("!")
    machine.cycles(300)
    machine.put("~")
    before = machine.world.place[:]
    machine.settle()
    assert machine.world.place[2] == -1800 and before != machine.world.place
    assert machine.world.place[0] == 3000 - 320
    assert machine.status()["state"] == "Idle"


def check_a_steep_helix():
    machine = machine_at_rest()
    steps, end = run_arc(machine, "G17 G91", "G3 X0 Y0 I0.05 J0 Z-10 F300")
    assert end == [0, 0, -4000]
    assert abs(hold_arc(steps, 0, 1, (0.05, 0), 0.05) - 1) < 0.1


def check_reset_drops_the_rest():
    machine = machine_at_rest()
    machine.put("G18 G91\nG2 X0 Z0 I-15 K0 P10 F5000\n")
    machine.cycles(300)
    machine.put(b"\x18")
    machine.cycles(300)
    machine.do("$X", "G17 G91", "G1 X1 F1000")
    at = machine.world.place[:]
    machine.settle()
    assert machine.world.place[1:] == at[1:]


def check_a_centre_between_steps():
    """It is rounded toward the start: on the other side the circle is off by more than a step."""
    check_any_arc(1508, 335, 323, 0, 0, 60)


def check_any_arc(radius, start, sweep, clockwise, plane, feed):
    """`radius` in hundredths of a millimetre, in the XZ or the YZ plane; the end is off by the programme's rounding."""
    from math import cos, sin

    machine = machine_at_rest()
    radius /= 100
    a, b = ((0, 2), (1, 2))[plane]
    first = start * pi / 180
    last = first + sweep * pi / 180 * (-1 if clockwise else 1)
    if plane == 0:
        clockwise = 1 - clockwise  # G18's plane is Z and X
    centre = -radius * cos(first), -radius * sin(first)
    end = centre[0] + radius * cos(last), centre[1] + radius * sin(last)
    if sweep == 360:
        end = 0, 0
    names, offsets = "XYZ", "IJK"
    steps, _ = run_arc(
        machine, ("G18 G91", "G19 G91")[plane],
        "G%d %s%.4f %s%.4f %s%.4f %s%.4f F%d" % (
            2 if clockwise else 3, names[a], end[0], names[b], end[1], offsets[a], centre[0], offsets[b], centre[1], feed
        ),
    )
    if radius > 0.2:
        assert abs(abs(hold_arc(steps, a, b, centre, radius)) - sweep / 360) < 0.01 / radius
