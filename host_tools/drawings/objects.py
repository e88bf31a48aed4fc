"""The five objects of the comparison of 2014, as points in steps for a machine of 10 steps/mm.

    for name, points in objects().items():      # points: [(pen_down, x, y), ...]
        ...

The document shows its objects as pictures only: these are of the same kinds, with the same point counts if it gives them.
"""

import math


def objects():
    """Return {name: [(pen_down, x, y), ...]} in steps, each with a MOVE from 0;0 first."""
    return {"square": square(), "triangle": triangle(), "spiral": spiral(), "text": text(), "circle": circle()}


def square():
    """5 points, side 40 mm."""
    return _pen_points([(200, 150), (200, 550), (600, 550), (600, 150), (200, 150)])


def triangle():
    """4 points, equilateral, side 40 mm."""
    return _pen_points([(200, 150), (600, 150), (400, 150 + 200 * math.sqrt(3)), (200, 150)])


def spiral():
    """25 points, three turns out to a radius of 30 mm."""
    return _pen_points([_polar_point(450, 400, 300 * i / 24, 6 * math.pi * i / 24) for i in range(25)])


def circle():
    """50 points, the last on the first, radius 25 mm."""
    return _pen_points([_polar_point(450, 400, 250, 2 * math.pi * i / 49) for i in range(50)])


def text():
    """74 points: PASSO in single strokes, letters of 12 × 21 mm on a pitch of 16.2 mm."""
    bowl = _arc_points(2.2, 5.25, 1.75, 1.75, 90, -90, 8)
    letter_p = [[(0, 0), (0, 7), *bowl, (0, 3.5)]]
    letter_a = [[(0, 0), (2, 7), (4, 0)], [(0.7, 2.45), (3.3, 2.45)]]
    letter_s = [_arc_points(2, 5.25, 2, 1.75, 30, 270, 10) + _arc_points(2, 1.75, 2, 1.75, 90, -150, 11)[1:]]
    letter_o = [_arc_points(2, 3.5, 2, 3.5, 90, 450, 18)]
    points = []
    for position, strokes in enumerate((letter_p, letter_a, letter_s, letter_s, letter_o)):
        for stroke in strokes:
            points += _pen_points([(200 + 30 * (x + 5.4 * position), 150 + 30 * y) for x, y in stroke])
    return points


def _arc_points(x, y, radius_x, radius_y, begin_deg, end_deg, count):
    """`count` points of an ellipse's arc, both ends included."""
    angles = [math.radians(begin_deg + (end_deg - begin_deg) * i / (count - 1)) for i in range(count)]
    return [(x + radius_x * math.cos(angle), y + radius_y * math.sin(angle)) for angle in angles]


def _polar_point(x, y, radius, angle):
    return x + radius * math.cos(angle), y + radius * math.sin(angle)


def _pen_points(positions):
    return [(index > 0, round(x), round(y)) for index, (x, y) in enumerate(positions)]
