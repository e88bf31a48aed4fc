"""The matrix of an SVG element: `translate`, `rotate`, `scale` and `transform`, in this order, about the element's transform-origin.

    matrix = of_style(style, viewport, box)     # `box()`: of the element in its own coordinates, for transform-box
    is_valid("transform", "rotate(45)")          # False: a style sheet wants units, an attribute does not

CSS Transforms 1 and 2, flat: a shape that is turned out of its plane is drawn as seen from the front.
"""

import math
import re

from host_tools.drawings import svg_geometry
from host_tools.drawings.svg_geometry import IDENTITY, compose_matrices

OF_STYLE = frozenset("translate rotate scale".split())  # no attributes: `rotate` of a <text> is another
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_ANGLE = rf"(?:{_NUMBER}(?:deg|grad|rad|turn)|[-+]?0)"
_LENGTH = rf"(?:{_NUMBER}(?:px|mm|cm|q|in|pt|pc|em|rem|ex|ch|%)|[-+]?0*\.?0+)"
_SHARE = rf"{_NUMBER}%?"
_STEP = re.compile(
    rf"\s*(?:translate(?:X|Y)?\(\s*{_LENGTH}(?:\s*,\s*{_LENGTH})?\s*\)|translate3d\((?:\s*{_LENGTH}\s*,){{2}}\s*{_LENGTH}\s*\)|translateZ\(\s*{_LENGTH}\s*\)"
    rf"|rotate[XYZ]?\(\s*{_ANGLE}\s*\)|skew[XY]?\(\s*{_ANGLE}(?:\s*,\s*{_ANGLE})?\s*\)|scale[XYZ]?\(\s*{_SHARE}(?:\s*,\s*{_SHARE})?\s*\)"
    rf"|scale3d\((?:\s*{_SHARE}\s*,){{2}}\s*{_SHARE}\s*\)|matrix\((?:\s*{_NUMBER}\s*,){{5}}\s*{_NUMBER}\s*\))\s*",
    re.I,
)
_CHECKS = {
    "transform": re.compile(rf"none|(?:{_STEP.pattern})+", re.I),
    "translate": re.compile(rf"none|{_LENGTH}(?:\s+{_LENGTH}){{0,2}}", re.I),
    "rotate": re.compile(rf"none|{_ANGLE}|[xyz]\s+{_ANGLE}|{_ANGLE}\s+[xyz]|(?:{_NUMBER}\s+){{3}}{_ANGLE}", re.I),
    "scale": re.compile(rf"none|{_SHARE}(?:\s+{_SHARE}){{0,2}}", re.I),
}  # fmt: skip
_FLAT = (  # functions in three dimensions: their flat part
    (re.compile(r"rotateZ\(", re.I), "rotate("), (re.compile(r"(?:translateZ|scaleZ)\([^)]*\)", re.I), ""),
    (re.compile(r"(translate|scale)3d\(([^,]+,[^,]+),[^)]*\)", re.I), r"\1(\2)"),
)  # fmt: skip
_TILT = re.compile(rf"rotate([XY])\(\s*({_ANGLE})\s*\)", re.I)
_TURNS = {"deg": math.pi / 180, "grad": math.pi / 200, "rad": 1.0, "turn": math.tau}
_BOXES = {"fill-box": "fill-box", "content-box": "fill-box", "stroke-box": "stroke-box", "border-box": "stroke-box"}


def is_valid(name, value):
    """True of a value that a style sheet may give a property of OF_STYLE, or `transform`."""
    return bool(_CHECKS[name].fullmatch(value.strip()))


def of_style(style, viewport, box):
    """Return the matrix of a style; `box(with_stroke)` returns left, top, width and height, or None. Raises ValueError, TooFar."""
    steps = [style.get(name, "none") for name in ("translate", "rotate", "scale", "transform")]
    if all(value == "none" for value in steps):
        return IDENTITY
    size = style["font-size"]
    kind = _BOXES.get(style.get("transform-box", "view-box").strip().lower())
    left, top, width, height = (box(kind == "stroke-box") if kind else None) or (0.0, 0.0, *viewport)
    found = compose_matrices(_translation_of(steps[0], (width, height), size), compose_matrices(_rotation_of(steps[1]), _scaling_of(steps[2])))
    found = compose_matrices(found, svg_geometry.read_matrix(_flatten_text(steps[3]), (width, height), size))
    origin = style.get("transform-origin")
    if not origin and not kind:
        return found
    found = svg_geometry.matrix_about(found, origin, (width, height), size) if origin else found
    return compose_matrices(compose_matrices((1.0, 0.0, 0.0, 1.0, left, top), found), (1.0, 0.0, 0.0, 1.0, -left, -top))


def _flatten_text(text):
    for pattern, flat in _FLAT:
        text = pattern.sub(flat, text)
    return _TILT.sub(lambda match: f"scale{'Y' if match[1] in 'Xx' else 'X'}({math.cos(_radians_of(match[2])):.12f})", text)


def _translation_of(text, whole, size):
    """Return the matrix of the property `translate`; `whole`: (width, height) of which per cent are, `size`: the font size, all in px. Raises
    TooFar."""
    if text == "none":
        return IDENTITY
    x, y = ([svg_geometry.length_px(part, side, size) for part, side in zip(text.split(), whole)] + [0.0])[:2]
    return (1.0, 0.0, 0.0, 1.0, x, y)


def _rotation_of(text):
    """Return the matrix of an angle, and an axis by its name or three numbers, flattened as seen from in front."""
    if text == "none":
        return IDENTITY
    words = text.lower().split()
    angle = next(word for word in reversed(words) if word not in ("x", "y", "z"))
    axes = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
    axis = next((axes[word] for word in words if word in axes), None) or (tuple(map(float, words[:3])) if len(words) == 4 else axes["z"])
    length = math.hypot(*axis)
    if not length:
        return IDENTITY
    x, y, z = (each / length for each in axis)
    cosine, sine = math.cos(_radians_of(angle)), math.sin(_radians_of(angle))
    rest = 1 - cosine
    return (cosine + x * x * rest, x * y * rest + z * sine, x * y * rest - z * sine, cosine + y * y * rest, 0.0, 0.0)


def _scaling_of(text):
    """Return the matrix of the property `scale`: factors or per cent, one for both axes or one each."""
    if text == "none":
        return IDENTITY
    shares = [float(word.rstrip("%")) / (100 if word.endswith("%") else 1) for word in text.split()]
    return (shares[0], 0.0, 0.0, shares[1] if len(shares) > 1 else shares[0], 0.0, 0.0)


def _radians_of(text):
    match = re.match(_NUMBER, text)
    number = float(match[0])
    return number * _TURNS.get(text[len(match[0]) :].lower(), 0.0)
