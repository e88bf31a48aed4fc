"""Pictures of a report as inline SVG: bars side by side, and points over a line.

    draw_bars(["square", "circle"], {"integer": [1.2, 3.4], "floating point": [1.9, 4.0]}, "ms")
    draw_dots({"R 20 mm": [(0, 0.1), (90, -0.2)]}, "angle, degrees", "steps")
"""

from html import escape
from math import ceil, floor, log10

from host_tools.experiments.row import figure_text

COLOURS = ("#20639b", "#ed8b00", "#3caea3", "#a23b72", "#6b7a8f")
WIDTH, HEIGHT = 640, 260
LEFT, RIGHT, TOP, BOTTOM = 56, 12, 30, 34
TICKS, DIGITS = 4, 3
NARROW = 30  # a bar whose figure is written smaller


def draw_bars(names, groups, unit):
    """Return an SVG of bars side by side. `groups`: {label: a value for each name}; None is a gap."""
    values = [value for each in groups.values() for value in each if value is not None]
    ends = _axis_scale(min([0, *values]), max([0, *values]))
    parts, wide = [], (WIDTH - LEFT - RIGHT) / len(names)
    width = min(0.8 * wide / len(groups), 46)
    for number, (colour, each) in enumerate(zip(COLOURS, groups.values())):
        for at, value in enumerate(each):
            if value is not None:
                x = LEFT + wide * (at + 0.5) + width * (number - len(groups) / 2)
                parts += _bar_parts(x, width, value, ends, colour)
    for at, name in enumerate(names):
        parts.append(_text_element(LEFT + wide * (at + 0.5), HEIGHT - BOTTOM + 18, name))
    return _svg_of(_axis_parts(ends, unit) + parts + _legend_parts(groups))


def draw_dots(groups, across, unit):
    """Return an SVG of points. `groups`: {label: [(x, y), …]}; `across`: label of the x axis."""
    points = [point for each in groups.values() for point in each]
    across_ends = _axis_scale(min(x for x, _y in points), max(x for x, _y in points))
    ends = _axis_scale(min(0, *(y for _x, y in points)), max(0, *(y for _x, y in points)))
    parts = []
    for colour, each in zip(COLOURS, groups.values()):
        for x, y in each:
            parts.append(f'<circle cx="{_x_of(x, across_ends):.1f}" cy="{_y_of(y, ends):.1f}" r="1.8" fill="{colour}"/>')
    for value in _tick_values(across_ends):
        parts.append(_text_element(_x_of(value, across_ends), HEIGHT - BOTTOM + 16, figure_text(value, DIGITS)))
    parts.append(_text_element(WIDTH - RIGHT, HEIGHT - 3, across, "end"))
    return _svg_of(_axis_parts(ends, unit) + parts + _legend_parts(groups))


def _axis_scale(low, high):
    """Return (first, last, step) of an axis around both values: a step of 1, 2 or 5 times a power of ten. Equal values get an axis around them."""
    if high == low:
        low, high = low - 1, high + 1
    rough = (high - low) / TICKS
    power = 10.0 ** floor(log10(rough))
    step = power * next(each for each in (1, 2, 5, 10) if each * power >= rough * 0.999)
    return floor(low / step + 1e-9) * step, ceil(high / step - 1e-9) * step, step


def _tick_values(ends):
    """Return the values of an axis at which it has a tick. `ends`: of _axis_scale()."""
    low, high, step = ends
    return [low + at * step for at in range(round((high - low) / step) + 1)]


def _x_of(value, ends):
    """Return the x of a value, in the SVG's units."""
    low, high, _step = ends
    return LEFT + (WIDTH - LEFT - RIGHT) * (value - low) / (high - low)


def _y_of(value, ends):
    """Return the y of a value, in the SVG's units: upwards is less."""
    low, high, _step = ends
    return HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * (value - low) / (high - low)


def _bar_parts(x, width, value, ends, colour):
    """Return a bar from zero to a value, and the figure above it."""
    top, zero = _y_of(value, ends), _y_of(0, ends)
    return [
        f'<rect x="{x:.1f}" y="{min(top, zero):.1f}" width="{width:.1f}" height="{abs(top - zero):.1f}" rx="1.5" fill="{colour}"/>',
        _text_element(x + width / 2, min(top, zero) - 4, figure_text(value, DIGITS), size=10 if width > NARROW else 8),
    ]


def _axis_parts(ends, unit):
    """Return the lines and figures of the y axis."""
    parts = [_text_element(LEFT, TOP - 14, unit, "end")]
    for value in _tick_values(ends):
        y = _y_of(value, ends)
        parts.append(f'<line x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{y:.1f}" y2="{y:.1f}" stroke="{"#555" if abs(value) < ends[2] / 9 else "#ddd"}"/>')
        parts.append(_text_element(LEFT - 6, y + 4, figure_text(value, DIGITS), "end"))
    return parts


def _legend_parts(groups):
    """Return the legend; [] of a single group."""
    if len(groups) < 2:
        return []
    parts, x = [], LEFT + 30
    for colour, label in zip(COLOURS, groups):
        parts += [f'<rect x="{x}" y="{TOP - 26}" width="11" height="11" fill="{colour}"/>', _text_element(x + 15, TOP - 16, label, "start", 11)]
        x += 26 + 6 * len(label)
    return parts


def _text_element(x, y, text, anchor="middle", size=12):
    """Return a text as an SVG element."""
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-size="{size}">{escape(str(text))}</text>'


def _svg_of(parts):
    """Return an SVG of these elements."""
    return f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img" font-family="sans-serif" fill="#333">{"".join(parts)}</svg>'
