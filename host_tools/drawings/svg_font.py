"""Fonts of an SVG file's text, among those of this computer.

    font = of(style, left_out)                     # matplotlib's, from font-family, font-weight and font-style
    ascent, descent, height_of_x = heights(font)   # parts of its size

A font that is not installed is replaced by the one that fontconfig takes for it, so that letters are as in librsvg, browsers and Inkscape on
the same computer; without fontconfig's `fc-match` matplotlib chooses. `left_out` is told so.
"""

import logging
import re
import subprocess
from functools import lru_cache

from host_tools.language import _

EM = 100.0  # matplotlib makes letters of this size
_GENERIC = {"sans-serif": "sans-serif", "serif": "serif", "monospace": "monospace", "cursive": "cursive",
            "fantasy": "fantasy", "system-ui": "sans-serif", "sans": "sans-serif"}  # fmt: skip
_USUAL = "Times New Roman,Liberation Serif,serif"  # of a text that names no font, as in librsvg


@lru_cache(maxsize=64)
def heights(font):
    """Ascent, descent and height of an x, as parts of a font's size."""
    from matplotlib import font_manager
    from matplotlib.textpath import text_to_path

    file = font_manager.get_font(font_manager.findfont(font))
    return file.ascender / file.units_per_EM, -file.descender / file.units_per_EM, text_to_path.get_text_width_height_descent("x", font, False)[1] / EM


def of(style, left_out):
    """matplotlib's font of a style; what stands for one that is not installed is named in `left_out`."""
    families = tuple(
        part.strip().strip("'\"") for part in style.get("font-family", _USUAL).split(",") if part.strip()
    )
    font, replaced = _found(families, style.get("font-weight", "normal"), style.get("font-style", "normal"))
    if replaced:
        left_out[_("the font {}, which is not on this computer ({} is drawn)", families[0], replaced)] = 1
    return font


@lru_cache(maxsize=256)
def _found(families, weight, slant):
    """matplotlib's font of a CSS family list, and the name of what stands for it if none of them is installed."""
    from matplotlib import font_manager

    known = {name.lower(): name for name in font_manager.get_font_names()}
    listed = next((name.lower() for name in families if name.lower() in known or name.lower() in _GENERIC), None)
    chosen = known.get(listed) or known.get(_fontconfig(families).lower()) or _GENERIC.get(listed, "sans-serif")
    number = int(weight) if weight.isdigit() else 400
    heavy = {"bold": 700, "bolder": 700, "lighter": 300}.get(weight, number if 1 <= number <= 1000 else 400)
    font = font_manager.FontProperties(
        family=[chosen], style=slant if slant in ("italic", "oblique") else "normal", weight=heavy, size=EM
    )
    logger = logging.getLogger("matplotlib.font_manager")
    before = logger.level
    logger.setLevel(logging.ERROR)
    try:
        name = font_manager.get_font(font_manager.findfont(font)).family_name
    finally:
        logger.setLevel(before)
    return font, None if listed else name


def _fontconfig(families):
    """Name of the font that fontconfig takes for a family list, "" without it."""
    names = ",".join(re.sub(r"([\\,:=-])", r"\\\1", name) for name in families)
    try:
        found = subprocess.run(["fc-match", "-f", "%{family[0]}", names], capture_output=True, text=True, timeout=10, check=True)
    except (OSError, subprocess.SubprocessError):
        return ""
    return found.stdout.strip()
