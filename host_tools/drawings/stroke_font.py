"""Letters of single lines, as pens write them: Hershey's Roman Simplex, by the package Hershey-Fonts, and the signs of measures.

    strokes = letter("A")           # complex arrays, y up; capitals are 1 high and stand on 0; x around 0, the widest 1
"""

from functools import lru_cache

import numpy

_HIGH, _WIDE, _BASE = 21.0, 16.0, 9.0  # capitals, and where they stand, in the font's own units
_SAME = {"\u2212": "-", "\u2013": "-", "\u2014": "-", "\u2010": "-", "\u2011": "-", "\u00ad": "-", "\u03bc": "\u00b5", "\u00ba": "\u00b0", "\u2019": "'", "\u00a0": " "}
_RING = [0.16 * numpy.exp(1j * numpy.pi * turn / 4) + 0.84j for turn in range(9)]
_SIGNS = {  # strokes as letter() returns them
    "\u00b0": [_RING],
    "\u00b1": [[-0.3 + 0.55j, 0.3 + 0.55j], [0.25j, 0.85j], [-0.3 + 0j, 0.3 + 0j]],
    "\u00b5": [[-0.35 - 0.33j, -0.25 + 0.67j], [-0.31 + 0.15j, -0.22 + 0j, 0j, 0.14 + 0.06j, 0.25 + 0.2j], [0.3 + 0.67j, 0.24 + 0.1j, 0.28 + 0j, 0.38 + 0.03j]],
    "\u00b7": [[0.35j, 0.4j]],
    "\u00d7": [[-0.25 + 0.1j, 0.25 + 0.6j], [-0.25 + 0.6j, 0.25 + 0.1j]],
}


@lru_cache(maxsize=1)
def _font():
    from HersheyFonts import HersheyFonts

    font = HersheyFonts()
    font.load_default_font("futural")
    return font


@lru_cache(maxsize=256)
def letter(text):
    """The strokes of a letter; None if the font has not got it."""
    text = _SAME.get(text, text)
    if text in _SIGNS:
        return [numpy.array(stroke) for stroke in _SIGNS[text]]
    if text not in _font().all_glyphs:
        return None
    strokes = [numpy.array([x + 1j * y for x, y in stroke]) for stroke in _font().strokes_for_text(text) if len(list(stroke))]
    if not strokes:
        return []
    everything = numpy.concatenate(strokes).real
    middle = (everything.min() + everything.max()) / 2
    placed = [(stroke.real - middle) / _WIDE + 1j * (_BASE - stroke.imag) / _HIGH for stroke in strokes]
    return [stroke if len(stroke) > 1 else numpy.repeat(stroke, 2) for stroke in placed]
