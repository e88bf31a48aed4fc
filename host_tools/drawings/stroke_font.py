"""Letters of single lines, as pens write them: Hershey's Roman Simplex, by the package Hershey-Fonts.

    strokes = letter("A")           # complex arrays, y up; capitals are 1 high and stand on 0; x around 0, the widest 1
"""

from functools import lru_cache

import numpy

_HIGH, _WIDE, _BASE = 21.0, 16.0, 9.0  # capitals, and where they stand, in the font's own units


@lru_cache(maxsize=1)
def _font():
    from HersheyFonts import HersheyFonts

    font = HersheyFonts()
    font.load_default_font("futural")
    return font


@lru_cache(maxsize=256)
def letter(text):
    """The strokes of a letter; None if the font has not got it."""
    if text not in _font().all_glyphs:
        return None
    strokes = [numpy.array([x + 1j * y for x, y in stroke]) for stroke in _font().strokes_for_text(text) if len(list(stroke))]
    if not strokes:
        return []
    everything = numpy.concatenate(strokes).real
    middle = (everything.min() + everything.max()) / 2
    placed = [(stroke.real - middle) / _WIDE + 1j * (_BASE - stroke.imag) / _HIGH for stroke in strokes]
    return [stroke if len(stroke) > 1 else numpy.repeat(stroke, 2) for stroke in placed]
