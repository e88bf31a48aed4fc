"""The program that faces a piece of work: rows to and fro over a rectangle, level by level, from outside in.

    lines = surface_lines({"x": 100, "y": 80, "tool": 20, "overlap": 40, "depth": 1, "cut": 0.5, "feed": 1500, "plunge": 300, "rpm": 12000, "safe": 5})

Zero of X and Y is the front left corner of the rectangle, zero of Z the top of the work. Sizes in mm, speeds in mm/min, `overlap` in per
cent of the tool. The tool goes down beside the work, never into it. It runs under MicroPython too, in a browser's tab.
"""

BESIDE_MM = 2.0  # between the tool and the work where it goes down
MOST_ROWS = 5000  # of all levels


def pass_depths(depth, cut):
    """Return the depths of the passes in mm, equal and none deeper than `cut`."""
    count = max(1, -int(-depth / cut // 1))
    return [depth * (n + 1) / count for n in range(count)]


def row_positions(y, step):
    """Return the positions of rows from 0 to `y`, in mm: equal, and no farther from each other than `step`."""
    count = max(1, -int(-y / step // 1))
    return [y * n / count for n in range(count + 1)]


def surface_lines(size):
    """Return the lines of G-code; None if there are more than MOST_ROWS rows."""
    step = size["tool"] * (1 - size["overlap"] / 100)
    passes = pass_depths(size["depth"], size["cut"])
    across = row_positions(size["y"], step)
    if len(passes) * len(across) > MOST_ROWS:
        return None
    out = size["tool"] / 2 + BESIDE_MM
    ends = (-out, size["x"] + out)
    lines = [
        "(Surfacing %g x %g mm, %g mm deep, tool %g mm: zero is front left on top)" % (size["x"], size["y"], size["depth"], size["tool"]),
        "G21 G90 G17 G94", "G0 Z%.3f" % size["safe"], "M3 S%d" % size["rpm"],
    ]  # fmt: skip
    for depth in passes:
        lines.append("G0 X%.3f Y%.3f" % (ends[0], across[0]))
        lines.append("G1 Z%.3f F%d" % (-depth, size["plunge"]))
        for n, y in enumerate(across):
            lines.append("G1 Y%.3f F%d" % (y, size["feed"]) if n else "G1 F%d" % size["feed"])
            lines.append("G1 X%.3f" % ends[1 - n % 2])
        lines.append("G0 Z%.3f" % size["safe"])
    return lines + ["M5", "G0 X0 Y0", "M2"]
