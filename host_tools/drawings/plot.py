"""A picture of a path: pen down dark, or in colours from first to last, pen up light, axes in mm, start and end
marked, the table around it."""

from host_tools.failure import Failure, reason
from host_tools.language import _

_DOWN = "#1a1a2e"
_UP = "#9cc3e6"
TABLE = "#b07a2a"
_PAGE = "#8a8a8a"


def title_of_trace(name, rows):
    """Return name and duration of a trace, from its first step to its end."""
    from host_tools.programs.estimate import clock_text

    if not rows:
        return name
    moved = (row for before, row in zip(rows, rows[1:]) if (row.x, row.y) != (before.x, before.y))
    seconds = (rows[-1].t_us - next(moved, rows[-1]).t_us) / 1e6
    return f"{name}, {clock_text(seconds)} ({seconds:.1f} s)"


def strokes_of_trace(rows, steps_per_mm):
    """Return [(pen_down, [(x, y), ...] in mm), ...] of a trace's rows; a tool other than 0 is down."""
    strokes = []
    for row in rows:
        position = (row.x / steps_per_mm[0], row.y / steps_per_mm[1])
        if strokes and strokes[-1][0] == bool(row.tool):
            strokes[-1][1].append(position)
        else:
            strokes.append((bool(row.tool), [strokes[-1][1][-1], position] if strokes else [position]))
    return strokes


def strokes_of_lines(lines, steps_per_mm):
    """Return [(pen_down, [(x, y), ...] in mm), ...] of polylines in steps, drawn from 0;0 in their order."""
    strokes = []
    pen = (0.0, 0.0)
    for line in lines:
        positions = [(x / steps_per_mm[0], y / steps_per_mm[1]) for x, y in line]
        strokes += [(False, [pen, positions[0]]), (True, positions)]
        pen = positions[-1]
    return strokes


def show_box(axes, box, label, color, style="-"):
    """Draw a rectangle (left, bottom, right, top in mm) behind the path, such as the table or the page."""
    left, bottom, right, top = box
    label = f"{label} {right - left:g} × {top - bottom:g} mm"
    xs, ys = (left, right, right, left, left), (bottom, bottom, top, top, bottom)
    axes.plot(xs, ys, color=color, linewidth=1.4, linestyle=style, label=label, zorder=1.5)


def save_picture(path, strokes, title, table=None, page=None, order=False):
    """Write the picture of `strokes` to `path`, with the reach of the machine and the page around it, each left, bottom,
    right, top in mm or None; `order`: colours from the first line to the last. Raises Failure if there are no strokes or it
    cannot be written."""
    from matplotlib.collections import LineCollection

    from host_tools.figures import pyplot

    if not strokes:
        raise Failure("an empty path has no picture")
    plt = pyplot()
    figure, axes = plt.subplots(figsize=(9, 8), layout="constrained")
    for pen_down, color, width in ((False, _UP, 0.6), (True, _DOWN, 0.9)):
        lines = [positions for down, positions in strokes if down == pen_down]
        if not lines:
            continue
        colors = plt.get_cmap("turbo")([i / len(lines) for i in range(len(lines))]) if order and pen_down else color
        axes.add_collection(
            LineCollection(lines, colors=colors, linewidths=width, capstyle="round", joinstyle="round",
                           label=_("pen down") if pen_down else _("pen up"))
        )
    for box, label, color, style in ((table, _("table"), TABLE, "-"), (page, _("page"), _PAGE, (0, (5, 4)))):
        if box is not None:
            show_box(axes, [round(side, 2) for side in box], label, color, style)
    start, end = strokes[0][1][0], strokes[-1][1][-1]
    axes.plot(*start, "o", color="#2a9d3f", markersize=8, label=_("start {:.1f}, {:.1f}", *start))
    axes.plot(*end, "s", color="#d03030", markersize=7, label=_("end {:.1f}, {:.1f}", *end))
    finish_axes(figure, axes, title)
    write(figure, path)


def finish_axes(figure, axes, title):
    """Set up the axes for a path seen from above: the same scale both ways, in mm, the legend below."""
    axes.autoscale()
    axes.margins(0.04)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel(_("x in mm"))
    axes.set_ylabel(_("y in mm"))
    axes.set_title(title)
    axes.grid(color="#e6e6e6", linewidth=0.5)
    axes.set_axisbelow(True)
    figure.legend(loc="outside lower center", ncols=3, frameon=False)


def write(figure, path, dpi=130):
    """Write a picture, and forget the figure. Raises Failure if it cannot be written."""
    import matplotlib.pyplot as plt

    try:
        figure.savefig(path, dpi=dpi)
    except (OSError, ValueError) as error:
        raise Failure("cannot write {}: {}", path, reason(error)) from error
    finally:
        plt.close(figure)
