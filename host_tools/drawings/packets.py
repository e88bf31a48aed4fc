"""Drawings in the words of `passo send`, one packet a line: MOVE 10 20, LINE 30 20, END."""


def packet_words(points):
    """Return an object, [(pen_down, x, y)] in steps, in the words of `passo send`, one packet a line."""
    return "".join(f"{'LINE' if pen else 'MOVE'} {round(x)} {round(y)}\n" for pen, x, y in points) + "END\n"


def packet_lines(path):
    """Return [(number, bytes)] of a job in these words, without blank lines and comments (#). Raises OSError."""
    lines = [line.split("#")[0].strip() for line in path.read_text(encoding="latin-1").splitlines()]
    return [(number, line.encode("latin-1")) for number, line in enumerate(lines, 1) if line]
