"""Fonts of an SVG file's text, among those of this computer.

    font = font_of(style, left_out, "text")              # matplotlib's, from font-family, font-weight and font-style
    ascent, descent, height_of_x = font_heights(font)    # parts of its size
    count = count_missing(font, "text")                   # letters that neither it nor those that stand in for it have

A font that is not installed is replaced by the one that fontconfig takes for its list of names, so that letters are as in librsvg, browsers and
Inkscape on the same computer; without fontconfig's `fc-match` matplotlib chooses. `left_out` names each stand-in. A font that was installed
after matplotlib made its list is found by fontconfig. Letters that a font has not come from one that has them, also as fontconfig takes it.
"""

import contextlib
import logging
import re
import subprocess
import unicodedata
from functools import lru_cache

from host_tools.language import N_, _

EM = 100.0  # matplotlib makes letters of this size
_GENERIC = {"sans-serif": "sans-serif", "serif": "serif", "monospace": "monospace", "cursive": "cursive",
            "fantasy": "fantasy", "system-ui": "sans-serif", "sans": "sans-serif"}  # fmt: skip
_SLANTED = ("italic", "oblique")
_USUAL = "Times New Roman,Liberation Serif,serif"  # of a text that names no font, as in librsvg


@lru_cache(maxsize=64)
def font_heights(font):
    """Return (ascent, descent, height of an x), as parts of a font's size."""
    from matplotlib import font_manager
    from matplotlib.textpath import text_to_path

    file = font_manager.get_font(font_manager.findfont(font))
    return file.ascender / file.units_per_EM, -file.descender / file.units_per_EM, text_to_path.get_text_width_height_descent("x", font, False)[1] / EM


def font_of(style, left_out, text=""):
    """Return matplotlib's font of a style, with fonts added for letters of `text` that it lacks. A font that is not installed is named in
    `left_out`, with its replacement."""
    named = tuple(part.strip().strip("'\"") for part in style.get("font-family", "").split(",") if part.strip())
    families = named or tuple(_USUAL.split(","))
    slant = style.get("font-style", "normal")
    chosen, font, replaced = _find_font(families, style.get("font-weight", 400), slant)
    if slant in _SLANTED and not _is_slanted(font):
        left_out[N_("slanted letters that the font has not (drawn upright)")] = 1
    strange = "".join(sorted(each for each in set(text) if count_missing(font, each)))
    if strange:
        font = _with_families(font, (chosen, *(_load_installed(families, f":charset={ord(each):x}") for each in strange)))
    if replaced and named:
        left_out[_("the font {}, which is not on this computer ({} is drawn)", families[0], replaced)] = 1
    return font


@lru_cache(maxsize=256)
def _find_font(families, weight, slant):
    """Return (name, matplotlib's font, name of the replacement or None) of a CSS family list. None: the font is of the first family, or generic."""
    from matplotlib import font_manager

    known = _font_names()
    wanted = families[0].lower()
    found = known.get(wanted) or _GENERIC.get(wanted) or _load_installed(families)
    listed = next((name.lower() for name in families if name.lower() in known or name.lower() in _GENERIC), None)
    chosen = found or known.get(listed) or _GENERIC.get(listed, "sans-serif")
    font = font_manager.FontProperties(family=[chosen], style=slant if slant in _SLANTED else "normal", weight=weight, size=EM)
    logging.getLogger("matplotlib.font_manager").setLevel(logging.ERROR)  # a weight that no font has is no news
    name = font_manager.get_font(font_manager.findfont(font)).family_name
    return chosen, font, None if wanted in _GENERIC or chosen.lower() == wanted else name


def _font_names():
    """Return {name in small letters: name} of matplotlib's list."""
    from matplotlib import font_manager

    return {name.lower(): name for name in font_manager.get_font_names()}


def _load_installed(families, of_which=""):
    """Make the family that fontconfig takes for a list known to matplotlib, whose own list may be older; return its name, "" without one."""
    from matplotlib import font_manager

    name = _ask_fontconfig(families, of_which)
    if name and name.lower() not in _font_names():
        for file in _files_of(name):
            with contextlib.suppress(OSError, RuntimeError, ValueError, KeyError):  # a kind of font that matplotlib does not read
                font_manager.fontManager.addfont(file)
    return _font_names().get(name.lower(), "")


def _with_families(font, families):
    """Return the font with several families: a letter comes from the first that has it."""
    font = font.copy()
    font.set_family([name for name in dict.fromkeys(families) if name] or font.get_family())
    return font


def count_missing(font, text):
    """Count the letters of `text` that no family of a font has."""
    return sum(unicodedata.category(each)[0] not in "CZ" and not any(ord(each) in letters for letters in _letter_sets(font)) for each in text)


@lru_cache(maxsize=256)
def _letter_sets(font):
    """Return the letters of each of a font's families."""
    from matplotlib import font_manager

    found = []
    for family in font.get_family():
        alone = font.copy()
        alone.set_family([family])
        found.append(frozenset(font_manager.get_font(font_manager.findfont(alone)).get_charmap()))
    return found


@lru_cache(maxsize=64)
def _is_slanted(font):
    from matplotlib import font_manager, ft2font

    return bool(font_manager.get_font(font_manager.findfont(font)).style_flags & ft2font.StyleFlags.ITALIC)


@lru_cache(maxsize=1024)
def _ask_fontconfig(families, of_which=""):
    """Return the name of the font that fontconfig takes for a family list, "" without it. `of_which`: further conditions."""
    return _run_program("fc-match", "-f", "%{family[0]}", _fontconfig_pattern(families) + of_which)


def _files_of(name):
    """Return the files of a family, as fontconfig lists them."""
    return [file for file in _run_program("fc-list", "-f", "%{file}\n", _fontconfig_pattern([name])).splitlines() if file]


def _fontconfig_pattern(families):
    return ",".join(re.sub(r"([\\,:=-])", r"\\\1", name) for name in families)


def _run_program(*words):
    """Return a program's output without blanks at its ends; "" if it is missing, fails, or takes more than 10 s."""
    try:
        return subprocess.run(words, capture_output=True, text=True, timeout=10, check=True).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return ""
