"""Letters of single lines, as pens write them: Hershey's Roman Simplex, by the package Hershey-Fonts, the signs of measures, and letters
with accents, which it has not, of their parts.

    strokes = letter_strokes("A")           # complex arrays, y up; capitals are 1 high and stand on 0; x around 0, the widest 1
"""

import unicodedata
from functools import lru_cache

import numpy

_HIGH, _WIDE, _BASE = 21.0, 16.0, 9.0  # capitals, and where they stand, in the font's own units
_SAME = {"\u2212": "-", "\u2013": "-", "\u2014": "-", "\u2010": "-", "\u2011": "-", "\u00ad": "-", "\u03bc": "\u00b5", "\u00ba": "\u00b0", "\u2019": "'", "\u00a0": " "}
_RING = [0.16 * numpy.exp(1j * numpy.pi * turn / 4) + 0.84j for turn in range(9)]
_SIGNS = {  # strokes as letter_strokes() returns them
    "\u00b0": [_RING],
    "\u00b1": [[-0.3 + 0.55j, 0.3 + 0.55j], [0.25j, 0.85j], [-0.3 + 0j, 0.3 + 0j]],
    "\u00b5": [[-0.35 - 0.33j, -0.25 + 0.67j], [-0.31 + 0.15j, -0.22 + 0j, 0j, 0.14 + 0.06j, 0.25 + 0.2j], [0.3 + 0.67j, 0.24 + 0.1j, 0.28 + 0j, 0.38 + 0.03j]],
    "\u00b7": [[0.35j, 0.4j]],
    "\u00d7": [[-0.25 + 0.1j, 0.25 + 0.6j], [-0.25 + 0.6j, 0.25 + 0.1j]],
    "\u00df": [[-0.35 + 0j, -0.35 + 0.8j, -0.2 + 1j, 0.1 + 1j, 0.25 + 0.85j, 0.25 + 0.7j, 0.55j, 0.3 + 0.35j, 0.3 + 0.15j, 0.1 + 0j, -0.1 + 0j]],
    "\u00a3": [[0.35 + 0.85j, 0.2 + 1j, 1j, -0.15 + 0.85j, -0.15 + 0.1j, -0.3 + 0j, 0.35 + 0j], [-0.35 + 0.5j, 0.15 + 0.5j]],
    "\u00a7": [[0.25 + 0.9j, 1j, -0.25 + 0.85j, -0.2 + 0.7j, 0.25 + 0.4j, 0.1 + 0.3j], [-0.25 + 0.05j, -0.05j, 0.25 + 0.1j, 0.2 + 0.25j, -0.25 + 0.55j, -0.1 + 0.65j]],
    "\u00a8": [[-0.18 + 1j, -0.18 + 1.05j], [0.18 + 1j, 0.18 + 1.05j]],
}  # fmt: skip
_ACCENTS = {  # of combining marks: strokes above the letter's middle; those of the cedilla below it
    "\u0300": [[-0.12 + 0.28j, 0.08 + 0.08j]], "\u0301": [[-0.08 + 0.08j, 0.12 + 0.28j]], "\u0302": [[-0.18 + 0.08j, 0.25j, 0.18 + 0.08j]],
    "\u0303": [[-0.22 + 0.1j, -0.12 + 0.22j, 0.12 + 0.1j, 0.22 + 0.22j]], "\u0308": [[-0.18 + 0.12j, -0.18 + 0.18j], [0.18 + 0.12j, 0.18 + 0.18j]],
    "\u030a": [0.11 * numpy.exp(1j * numpy.pi * numpy.arange(9) / 4) + 0.19j], "\u030c": [[-0.18 + 0.25j, 0.08j, 0.18 + 0.25j]],
    "\u0327": [[0j, 0.1 - 0.1j, -0.2j, -0.1 - 0.2j]],
}  # fmt: skip
_STRUCK = {"\u00d8": "O", "\u00f8": "o"}  # with a stroke through
_TURNED = {"\u00bf": "?", "\u00a1": "!"}
_JOINED = {"\u00c6": "AE", "\u00e6": "ae", "\u0152": "OE", "\u0153": "oe"}


@lru_cache(maxsize=1)
def _load_font():
    """Return Hershey's Roman Simplex ("futural" of HersheyFonts), loaded once."""
    from HersheyFonts import HersheyFonts

    font = HersheyFonts()
    font.load_default_font("futural")
    return font


@lru_cache(maxsize=256)
def letter_strokes(text):
    """Return the strokes of a letter; None if the font has not got it."""
    text = _SAME.get(text, text)
    if text in _SIGNS:
        return [numpy.array(stroke) for stroke in _SIGNS[text]]
    if text not in _load_font().all_glyphs:
        return _of_parts(text)
    strokes = [numpy.array([x + 1j * y for x, y in stroke]) for stroke in _load_font().strokes_for_text(text) if len(list(stroke))]
    if not strokes:
        return []
    everything = numpy.concatenate(strokes).real
    middle = (everything.min() + everything.max()) / 2
    placed = [(stroke.real - middle) / _WIDE + 1j * (_BASE - stroke.imag) / _HIGH for stroke in strokes]
    return [stroke if len(stroke) > 1 else numpy.repeat(stroke, 2) for stroke in placed]


def _of_parts(text):
    """Return the strokes of a letter that the font has not got, made of other letters; None if there are none."""
    if text in _TURNED:
        return [(2 / 3) * 1j - stroke for stroke in letter_strokes(_TURNED[text])]
    if text in _STRUCK:
        strokes = letter_strokes(_STRUCK[text])
        high = max(stroke.imag.max() for stroke in strokes)
        return [*strokes, numpy.array([-0.45 - 0.05j, 0.45 + (high + 0.05) * 1j])]
    if text in _JOINED:
        return [stroke.real * 0.55 + side + 1j * stroke.imag for side, each in zip((-0.22, 0.22), _JOINED[text]) for stroke in letter_strokes(each)]
    base, *marks = unicodedata.normalize("NFD", text)
    if not marks or base not in _load_font().all_glyphs or any(mark not in _ACCENTS for mark in marks):
        return None
    strokes = letter_strokes(base)
    if base in "ij":
        strokes = [stroke for stroke in strokes if stroke.imag.min() < 0.8]  # without its dot
    top = 2j / 3 if base.islower() else 1j
    for mark in marks:
        strokes = [*strokes, *(numpy.array(stroke) + (0 if mark == "\u0327" else top) for stroke in _ACCENTS[mark])]
    return strokes
