"""Paints of an SVG file that are elements: gradients and patterns, by "url(#id)".

    paint = of("url(#a) red", by_id)        # ("red", None) if there is no #a, ("none", None) of a gradient without colours
    paint = of("url(#p)", by_id)            # ("url(#p)", "pattern"): an area of it is drawn as its edge
    paint = of("context-fill", by_id)       # ("context-fill", "context"): taken to be a colour
"""

import re

from host_tools.drawings.svg_style import local_name

_PAINT = re.compile(r"url\(\s*['\"]?#([^'\")]+)['\"]?\s*\)\s*(.*)", re.S)
_HREF = "{http://www.w3.org/1999/xlink}href"
_MOST = 20  # gradients that lead to each other
_KINDS = {"linearGradient": "gradient", "radialGradient": "gradient", "pattern": "pattern"}


def of(value, by_id):
    """(the paint that counts; its kind, "gradient", "pattern", "context" or None)."""
    match = _PAINT.match(value)
    if not match:
        return value, "context" if value.startswith("context-") else None
    element = by_id.get(match[1])
    kind = None if element is None else local_name(element.tag)
    if kind not in _KINDS:
        return match[2].strip() or "none", None
    parts = _parts(element, by_id)
    if parts == 1 and _KINDS[kind] == "gradient":
        return value, None  # one colour
    return (value, _KINDS[kind]) if parts else ("none", None)


def _parts(element, by_id):
    """How many colours a gradient, or the one that it leads to, has, or a pattern shapes."""
    for _again in range(_MOST):
        if element is None:
            return 0
        found = sum(local_name(child.tag) != "" for child in element)
        if found:
            return found
        element = by_id.get((element.get("href") or element.get(_HREF) or "").removeprefix("#"))
    return 0
