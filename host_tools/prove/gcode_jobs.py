"""Small programmes of every kind, made the same way each time: for digests, fuzz and benches.

    all_jobs()["relief"]     # (board, lines)

"pico" is the beginnings of some, one after the other, short enough for an emulated chip.
"""

from math import cos, pi, sin


def relief():
    """Return a surface in scan lines of short 3-axis moves, up and down by turns."""
    lines = ["G21 G90", "G0 Z1", "G0 X0 Y0", "M3 S12000", "G1 Z0 F400"]
    for row in range(5):
        columns = range(37) if row % 2 == 0 else range(36, -1, -1)
        for column in columns:
            x, y = column * 0.2, row * 0.3
            lines.append("G1 X%.3f Y%.3f Z%.3f F1500" % (x, y, 0.4 * sin(x) * cos(2 * y) - 0.5))
    return [*lines, "G0 Z1", "M5"]


def engraving():
    """Return letters of short strokes, with rapid moves between them."""
    lines = ["G21 G90 F900", "G0 Z0.5"]
    for letter in range(9):
        left = letter * 2.2
        lines += ["G0 X%.3f Y0" % left, "G1 Z-0.2 F300", "G1 Y2.5 F900"]
        for part in range(1, 13):
            angle = pi * part / 12
            lines.append("G1 X%.3f Y%.3f" % (left + 1.25 * sin(angle), 1.25 + 1.25 * cos(angle)))
        lines += ["G1 X%.3f Y1.25" % (left + 1.1), "G0 Z0.5"]
    return lines


def arcs():
    """Return arcs of many radii, both ways, by IJ and by R, and whole circles."""
    lines = ["G21 G90 F1200", "G0 X20 Y20"]
    for number in range(1, 7):
        radius = number * 0.37
        lines.append("G%d X20 Y20 I%.3f J%.3f" % (2 + number % 2, radius, radius / 2))
        lines.append("G%d X%.3f Y20 R%.3f" % (3 - number % 2, 20 + radius, radius))
        lines.append("G%d X20 Y20 R-%.3f" % (2 + number % 2, radius))
    return lines


def helices():
    """Return thread milling: helices of a part of a turn to several turns, in every plane."""
    lines = ["G21 G90 F800", "G0 X5 Y5 Z0"]
    for turns in range(1, 4):
        lines += ["G3 X5 Y5 Z-%d I1.5 J0 P%d" % (turns, turns), "G2 X5 Y5 Z0 I-0.8 J0.4 P%d" % turns]
    lines += ["G18 G2 X7 Z2 I1 K1", "G3 X5 Z0 R1.6 Y6", "G19 G2 Y8 Z0 J1 K0.2 X5.5", "G17 G1 X5 Y5 Z0"]
    return [*lines, "G91 G2 X1 Y0 I0.5 Z-0.25", "G3 X-1 Y0 I-0.5 Z0.25", "G90"]


def laser_raster():
    """Return a picture in lines of dots, each with its own power, which follows the speed."""
    lines = ["G21 G90 M4 S0", "G0 X1 Y1"]
    for row in range(4):
        columns = range(1, 41) if row % 2 == 0 else range(39, -1, -1)
        for column in columns:
            shade = int(500 + 499 * sin(column * 0.4) * cos(row))
            lines.append("G1 X%.2f S%d F6000" % (1 + column * 0.25, shade if column % 7 else 0))
        lines.append("G0 Y%.2f" % (1 + 0.2 * (row + 1)))
    return [*lines, "M5"]


def tiny():
    """Return a spiral of segments far shorter than the way to a stand."""
    lines = ["G21 G90 G1 F2400"]
    for number in range(600):
        angle = number * 0.05
        lines.append("X%.3f Y%.3f" % (0.01 * number * cos(angle), 0.01 * number * sin(angle)))
    return lines


def drilling():
    """Return holes by the canned cycle, with both ways back, dwells, and a tool change's offset."""
    lines = ["G21 G90", "G0 Z4", "M3 S3000", "G98 G81 X2 Y2 Z-3 R1 F200", "X4", "X6 Y3", "G99 X8", "X10 Y2", "G80"]
    return [*lines, "G4 P0.05", "G43.1 Z1.5", "G98 G81 X4 Y6 Z-2 R2", "G91 X2 Z-4 R2.5 L3", "G90 G80", "G49", "G0 Z4", "M5", "M30"]


def units():
    """Return inches, inverse time, relative moves, work offsets, G28 and G92."""
    lines = ["G20 G90 G94 F20", "G1 X0.5 Y0.25", "G93 G1 X0.75 F30", "X0.5 F60", "G94 G21 F700", "G91 G1 X3.333 Y-1.111"]
    lines += ["X0.001", "X0.001", "X0.001 Z-0.777", "G90 G10 L2 P2 X4 Y4 Z1", "G55 G1 X0 Y0 Z0", "G92 X1 Y1", "X2 Y2"]
    return [*lines, "G92.1 G54", "G28.1", "G1 X9 Y1", "G28 X5", "G53 G0 X1 Y1", "G1 X2 F90 Y2", "G0 X0 Y0 Z0"]


def reversals():
    """Return moves back and forth along each axis and each diagonal, with corners of every angle."""
    lines = ["G21 G90 F3000"]
    for number in range(1, 30):
        angle = number * 2.4
        lines.append("G1 X%.3f Y%.3f Z%.3f" % (5 * cos(angle), 4 * sin(angle), sin(number * 0.7)))
    return lines


def slow():
    """Return moves below a step a millisecond, and a few steps at a time."""
    lines = ["G21 G91 F6"]
    for number in range(1, 30):
        lines.append("G1 X%.4f Y%.4f Z-%.4f" % (0.003 * number, 0.02 / number, 0.0025 * (number % 3)))
    return lines


def smooth():
    """Return a job of limited jerk: ramps inside lines, over a spiral of tiny ones, on arcs and a helix, and at another jerk."""
    lines = ["$141=30000", "G21 G90", "G0 X20 Y12 Z-3", "G0 X5", "G1 F2400 X0 Y0"]
    lines += tiny()[1:200]
    lines += ["X0 Y4", "G2 X4 I2 F1500", "G3 X4 Y4 Z-2 I3 J1 P2", "G4 P0.1"]
    lines += ["$141=2500", "G1 X9 F3000", "G2 X9 Y4 I0.3", "G1 X4.01", "X4"]
    return lines


def star(points=7, centre=(40, 40), size=30):
    """Return strokes in every direction from a middle and back, their ends joined, a circle around them: for two motors on one belt."""
    x, y = centre
    ends = [(x + size * cos(2 * pi * k / (2 * points)), y + size * sin(2 * pi * k / (2 * points))) for k in range(2 * points)]
    lines = ["G21 G90 G17 F6000", "G0 X%d Y%d" % centre]
    for end in ends:
        lines += ["M3 S1000", "G1 X%.3f Y%.3f" % end, "G1 X%d Y%d" % centre]
    lines += ["M5", "G0 X%.3f Y%.3f" % ends[0], "M3"]
    lines += ["G1 X%.3f Y%.3f" % ends[k * 3 % len(ends)] for k in range(1, len(ends) + 1)]
    return [*lines, "G2 X%.3f Y%.3f I%d" % (ends[0] + (-size,)), "G3 X%.3f Y%.3f R%d F9000" % (ends[points // 2 + 1] + (size,)), "M5", "G0 X0 Y0"]


def backlash_job():
    """Return a job that turns round axes with lost motion in every way: zigzags, circles in every plane, helices, short lines, one axis alone,
    inverse time."""
    lines = ["G21 G90 G17 F1500", "G0 X20 Y20 Z-5", "M3 S1000"]
    lines += ["G1 X%.3f Y%.3f Z%.2f" % (20 + k / 2, 20 + k % 2 * 1.5, -5 - k % 3 / 4) for k in range(30)]
    lines += ["G1 X35 Y20 Z-5", "G2 X35 Y20 I5 J0", "G3 X35 Y20 I-3 J2 Z-6 P2", "G18 G2 X35 Z-6 I2 K1", "G19 G3 Y20 Z-6 J1 K-2", "G17"]
    lines += ["G1 X%.4f Y%.4f" % (35 + 4 * sin(k / 9), 20 + 4 * cos(k / 7)) for k in range(150)]
    lines += ["G1 X30 F600", "X31", "X30.99", "X31", "Z-5.99", "Z-6", "G0 Y10", "X10 Y12", "G93 G1 X12 Y19 F40", "X11 Y20 F40"]
    return lines + ["G94 G1 X11.003 Y20.003 F300", "X11 Y20", "M5", "G0 X0 Y0 Z0"]


def table():
    """Return a job of a rotary table under a cutter: wound lines, A alone, each feed, arcs while A stands, its own zero, short lines and reversals."""
    lines = ["G21 G90 G17 F900", "G0 X2 Y1 A-8", "M3 S1000", "G1 Z-0.3 A4 F300", "X4 A22 F600", "Y2.5 Z-0.6 A10", "A31 F3000", "A30.98"]
    lines += ["X%.3f A%.3f" % (4 + k / 40, 30 + 6 * sin(k / 3)) for k in range(25)]
    lines += ["G2 X5 Y2 R0.6", "G3 X6 Z-0.2 R0.8", "G93 G1 X5 A20 F60", "A26 F120", "G94 F400", "G92 A0", "G1 A5 X5.5", "G92.1"]
    return [*lines, "G91 G1 Y-0.5 A-4 F500", "X0.003 A0.02", "X0.003 A-0.02", "G90 M5", "G0 X2 Y1 Z0 A0"]


def belt():
    """Return a small star(), whose motors now share the work, now leave it to one; arcs, and lines of a step or two."""
    lines = [line for line in star(5, (6, 6), 2) if not line.startswith("G0 X0")]
    lines += ["G1 X%.4f Y%.4f F3000" % (5 + k / 80, 7 + k * k % 7 / 80) for k in range(30)]
    return [*lines, "G93 G1 X5 Y8 F200", "G94", "G91 G2 X1 Y1 R0.9 F4000", "G3 X0 Y0 I-0.5 J0.25", "G90 G0 X0 Y0"]


def short_backlash_job():
    """Return backlash_job() in short: each axis with lost motion turns round amid lines, arcs in two planes, steps of less than the play, and alone."""
    lines = ["G21 G90 G17 F1200", "G0 X2 Y2 Z-1", "M3 S1000"]
    lines += ["X%.3f Y%.3f Z%.2f" % (2 + k / 8, 2 + k % 2 / 2, -1 - k % 3 / 10) for k in range(12)]
    lines[3] = "G1 " + lines[3]
    lines += ["X3.5 Y2 Z-1", "G2 I0.5 J0.3 X3.5", "G3 X3.5 I-0.4 J0.2 Z-1.2", "G18 G2 X4 Z-1 R0.4", "G17"]
    lines += ["G1 X%.4f Y%.4f" % (4 + 0.4 * sin(k / 3), 2 + 0.4 * cos(k / 2)) for k in range(40)]
    return [*lines, "X3.5 F600", "X3.51", "X3.5", "Z-0.99", "Z-1", "G93 X4 Y1.5 F100", "X3.9 Y1.6 F100", "G94", "M5", "G0 X0 Y0 Z0"]


MACHINES = {"table": ("router_4axis", table), "belt": ("corexy_plotter", belt), "turns": ("router_ballscrew", short_backlash_job)}
PICO = ((relief, 9), (engraving, 8), (helices, 3), (laser_raster, 11))  # and how many lines


def all_jobs():
    """Return {name: (board, lines)}."""
    made = {}
    for kind in (relief, engraving, arcs, helices, laser_raster, tiny, drilling, units, reversals, slow, smooth):
        made[kind.__name__] = ("laser_xy" if kind is laser_raster else "router_3axis", kind())
    made |= {name: (board, lines()) for name, (board, lines) in MACHINES.items()}
    made["pico"] = ("router_3axis+laser", [line for kind, count in PICO for line in kind()[:count]])
    return made
