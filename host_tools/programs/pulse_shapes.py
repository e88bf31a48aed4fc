"""The example cuts of LPTControl's document as pulse files: closed, with diagonals at the same path speed.

    shape_text("octagon", steps_per_mm=80)

Plain Python: MicroPython runs it in the tests, too.
"""

# Corners in cm, all sides along an axis or at 45°; the last side leads back to the first corner.
SHAPES = {
    "square": ((0, 0), (10, 0), (10, 10), (0, 10)),
    "triangle": ((0, 0), (10, 0), (0, 10)),
    "hexagon": ((5, 0), (10, 0), (15, 5), (10, 10), (5, 10), (0, 5)),
    "octagon": ((5, 0), (10, 0), (15, 5), (15, 10), (10, 15), (5, 15), (0, 10), (0, 5)),
}
# The code of a step in each direction (x, y).
_CODES = {(1, 0): "A", (-1, 0): "B", (0, 1): "C", (0, -1): "D", (1, 1): "G", (1, -1): "H", (-1, 1): "I", (-1, -1): "J"}
_LINE = 100  # codes


def shape_text(shape, steps_per_mm, speed=1000, down=None):
    """Return the file of a shape: `[`, the speed in mm/min, the tool on, the sides, all off. `down`: steps by which the tool goes down (Z−) before
    it cuts, and up again behind."""
    corners = SHAPES[shape]
    steps = round(10 * steps_per_mm)
    parts = ["[\n+%d\n(\n" % speed]
    if down:
        parts.append(break_lines("F" * down))
    for number in range(len(corners)):
        x, y = corners[number]
        to_x, to_y = corners[(number + 1) % len(corners)]
        count = max(abs(to_x - x), abs(to_y - y))
        code = _CODES[((to_x > x) - (to_x < x), (to_y > y) - (to_y < y))]
        parts.append(break_lines(code * (count * steps)))
    if down:
        parts.append(break_lines("E" * down))
    parts.append(")\n]\n")
    return "".join(parts)


def break_lines(codes):
    """Break `codes` into lines of a length that editors show well."""
    return "".join([codes[at : at + _LINE] + "\n" for at in range(0, len(codes), _LINE)])
