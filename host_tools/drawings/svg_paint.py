"""Paints of an SVG file that are elements: gradients and patterns, by "url(#id)".

    paint = paint_of("url(#a) red", by_id, style_of)      # ("red", None) if there is no #a, ("none", None) of a gradient without colours
    paint = paint_of("url(#p)", by_id, style_of)          # ("url(#p)", "pattern"): an area of it is drawn as its edge
    paint = paint_of("url(#w)", by_id, style_of)          # ("white", None) of a gradient or pattern that is white all over
    paint = paint_of("context-fill", by_id, style_of)     # ("context-fill", "context"): taken to be a colour
"""

import re

from host_tools.drawings import svg_style
from host_tools.drawings.svg_style import local_name

_PAINT = re.compile(r"url\(\s*['\"]?#([^'\")]+)['\"]?\s*\)\s*(.*)", re.S)
_HREF = "{http://www.w3.org/1999/xlink}href"
_MOST = 20  # gradients that lead to each other
_SHAPES = frozenset("rect circle ellipse line polyline polygon path".split())
_NOT_SEEN = frozenset(("", "g", "title", "desc", "metadata"))
_WHOLE = re.compile(r"\s*(1(\.0*)?|100(\.0*)?%)\s*")
_WHITE_IN_PARTS = "rgba(255, 255, 255, 0.5)"  # the page, or a shape below, is seen through it
_KINDS = {"linearGradient": "gradient", "radialGradient": "gradient", "pattern": "pattern"}


def paint_of(value, by_id, style_of):
    """Return (the paint that counts; its kind, "gradient", "pattern", "context" or None). `style_of(element)`: its properties, as texts."""
    match = _PAINT.match(value)
    if not match:
        return value, "context" if value.startswith("context-") else None
    element = by_id.get(match[1])
    kind = None if element is None else local_name(element.tag)
    if kind not in _KINDS:
        return match[2].strip() or "none", None
    parts = _paint_parts(element, by_id)
    if not parts:
        return "none", None
    if _KINDS[kind] == "pattern":
        return (_WHITE_IN_PARTS, None) if _is_white_pattern(parts, style_of) else (value, "pattern")
    styles = [style_of(each) for each in parts]
    if all(svg_style.is_white(style.get("stop-color", "black")) for style in styles):
        return ("white" if all(_WHOLE.fullmatch(style.get("stop-opacity", "1")) for style in styles) else _WHITE_IN_PARTS), None
    return (value, None) if len(parts) == 1 else (value, "gradient")  # one colour


def _paint_parts(element, by_id):
    """Return the colours of a gradient, or of the one to which it leads, or the shapes of a pattern."""
    for _again in range(_MOST):
        if element is None:
            break
        found = [child for child in element if local_name(child.tag) != ""]
        if found:
            return found
        element = by_id.get((element.get("href") or element.get(_HREF) or "").removeprefix("#"))
    return []


def _is_white_pattern(parts, style_of):
    """True if a pattern has only white shapes; between them the white page is seen."""
    shapes = [child for part in parts for child in part.iter() if local_name(child.tag) not in _NOT_SEEN]
    styles = [style_of(shape) for shape in shapes]
    return all(local_name(shape.tag) in _SHAPES for shape in shapes) and all(
        not svg_style.is_painted(style, what) or svg_style.is_white(style.get(what, "black")) for style in styles for what in ("fill", "stroke")
    )
