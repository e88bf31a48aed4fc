"""Pictures of a drawing as `passo draw` would draw it: PNG, SVG, or dots in the terminal."""

from pathlib import Path

from host_tools.drawings import drawing, placement, plot
from host_tools.failure import Failure, reason
from host_tools.language import _
from host_tools.programs import estimate

_PENS = ("black", "#d02020", "#1f5fd0", "#1a8a3a", "#c07000", "#8030a0", "#008a8a", "#707070")
_TERMINAL = Path("-")


def write(console, path, plan, machine, seconds):
    """Write a picture of a drawing: .svg, .png, or `-` for dots in the terminal. `seconds`: its estimated time. Raises Failure if the file cannot be
    written."""
    name = ", ".join(Path(part).name for part in plan.name.split(", "))
    if path == _TERMINAL:
        console.print(in_dots(plan, placement.table_mm(machine), console.width, console.height), highlight=False)
    elif path.suffix.lower() == ".svg":
        _write_svg(path, plan, placement.table_mm(machine))
    else:
        title = _("{} at {} %, about {}", name, drawing.percent_text(plan.scale), estimate.clock_text(seconds))
        table = (0.0, 0.0, *placement.table_mm(machine))
        plot.save_picture(path, plot.strokes_of_lines(plan.lines, plan.steps_per_mm), title, table, plan.page_mm)


def in_dots(plan, table, columns, rows):
    """Return the table (mm) and the drawing as braille, as large as `columns` by `rows` of the terminal allow."""
    from host_tools.cli.watch import braille_map

    wide, high = max(10, columns - 2), max(5, rows - 4)
    scale = min(2 * wide / table[0], 4 * high / table[1])  # dots a mm
    wide, high = max(1, round(table[0] * scale / 2)), max(1, round(table[1] * scale / 4))
    right, top = table
    positions = [(0.0, 0.0), (right, 0.0), (right, top), (0.0, top), (0.0, 0.0)]
    for line in plan.lines:
        positions += [None, *((x / plan.steps_per_mm[0], y / plan.steps_per_mm[1]) for x, y in line)]
    return braille_map(positions, wide, high)


def _write_svg(path, plan, table):
    """Write an SVG file, each pen a group with a colour of its own: it can be drawn again. `table`: (width, height) in mm. Raises Failure."""
    groups = []
    for index, part in enumerate(plan.parts):
        data = []
        for line in part.lines:
            mm = [f"{x / plan.steps_per_mm[0]:.3f} {table[1] - y / plan.steps_per_mm[1]:.3f}" for x, y in line]
            data.append("M" + "L".join(mm))
        groups.append(f'<g id="layer{part.number}" stroke="{_PENS[index % len(_PENS)]}"><path d="{"".join(data)}"/></g>')
    head = f'<svg xmlns="http://www.w3.org/2000/svg" width="{table[0]:g}mm" height="{table[1]:g}mm" viewBox="0 0 {table[0]:g} {table[1]:g}"'
    style = 'fill="none" stroke-width="0.3" stroke-linecap="round" stroke-linejoin="round"'
    try:
        path.write_text("\n".join([f"{head} {style}>", *groups, "</svg>", ""]), encoding="utf-8")
    except OSError as error:
        raise Failure("cannot write {}: {}", path, reason(error)) from error
