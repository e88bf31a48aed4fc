"""Paints of an SVG file that are elements: gradients and patterns, by "url(#id)".

    paint = of("url(#a) red", by_id)        # ("red", None) if there is no #a, ("none", None) of a gradient without colours
    paint = of("url(#p)", by_id)            # ("url(#p)", "pattern"): an area of it is drawn as its edge
"""

import re

from host_tools.drawings.svg_style import local_name

_PAINT = re.compile(r"url\(\s*['\"]?#([^'\")]+)['\"]?\s*\)\s*(.*)", re.S)
_HREF = "{http://www.w3.org/1999/xlink}href"
_MOST = 20  # gradients that lead to each other
_KINDS = "linearGradient", "radialGradient", "pattern"


def of(value, by_id):
    """(the paint that counts, the kind of its element or None)."""
    match = _PAINT.match(value)
    if not match:
        return value, None
    element = by_id.get(match[1])
    kind = None if element is None else local_name(element.tag)
    if kind not in _KINDS:
        return match[2].strip() or "none", None
    return (value, kind) if _filled(element, by_id) else ("none", None)


def _filled(element, by_id):
    """True if a gradient, or one that it leads to, has a colour, a pattern something in it."""
    for _again in range(_MOST):
        if element is None:
            return False
        if any(local_name(child.tag) for child in element):
            return True
        element = by_id.get((element.get("href") or element.get(_HREF) or "").removeprefix("#"))
    return False
