"""Styles of an SVG file: attributes, style sheets and `style` of an element, and the properties it inherits.

    sheet = Sheet([".st0{stroke:#000}"], root)
    style = sheet.style(element, inherited)         # {"stroke": "#000", …}

Supports the properties that decide whether, where and how an outline is drawn. tinycss2 reads the sheets and cssselect2 matches
their selectors; rules of @media hold if a screen would take them. Rules that cannot be read go to `unknown`.
"""

import math
import re
from functools import lru_cache

from host_tools.drawings import svg_transform
from host_tools.drawings.svg_geometry import length_px

_LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"
_INHERITED = frozenset(
    "visibility fill stroke stroke-width stroke-dasharray stroke-dashoffset stroke-linecap clip-rule marker-start "
    "marker-mid marker-end font-family font-size font-style font-weight text-anchor letter-spacing word-spacing white-space "
    "writing-mode font-stretch font-variation-settings stroke-opacity fill-opacity fill-rule color text-transform direction font-variant dominant-baseline".split()
)
_OWN = frozenset("display clip-path mask filter overflow baseline-shift alignment-baseline text-decoration shape-inside opacity stop-color stop-opacity transform transform-origin transform-box offset-path".split())
_KNOWN = _INHERITED | _OWN
_GEOMETRY = {  # of which elements an attribute is a property, too
    "rect": frozenset("x y width height rx ry".split()), "svg": frozenset("width height".split()), "use": frozenset("x y".split()),
    "circle": frozenset("cx cy r".split()), "ellipse": frozenset("cx cy rx ry".split()), "path": frozenset("d"),
}  # fmt: skip
_OF_SHEETS = svg_transform.OF_STYLE | {"transform"}
_KEYWORDS = ("inherit", "initial", "unset")
_SIGNED = ("x", "y", "cx", "cy")
_SIDE = re.compile(r"([-+]?)(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?(?:px|mm|cm|q|in|pt|pc|r?em|ex|ch|%)?", re.I)
_PATH = re.compile(r"path\(\s*(['\"])(.*)\1\s*\)", re.I | re.S)
_UNIT = re.compile(r"[\d.](?:deg|g?rad|turn|px|mm|cm|q|in|pt|pc|r?em|ex|ch|%)", re.I)
UNREAD = "unread"  # how many values of an element's style cannot be read, or are none in a style sheet
_SIZES = {"xx-small": 9.0, "x-small": 10.0, "small": 13.0, "medium": 16.0, "large": 18.0, "x-large": 24.0, "xx-large": 32.0, "xxx-large": 48.0}
_STEPS = {"smaller": 1 / 1.2, "larger": 1.2}
_SHORTHANDS = {
    "marker": ("marker-start", "marker-mid", "marker-end"), "-webkit-transform": ("transform",), "-webkit-transform-origin": ("transform-origin",), "offset": ("offset-path",),
}  # fmt: skip
_SILENT = frozenset("charset namespace font-face page".split())  # nothing to draw by
_QUERY = re.compile(r"(?:(?:(not)|only)\s+)?(\w[\w-]*)?(?:\s*and\s*)?(\(.*\))?$", re.S)
_ZERO = re.compile(r"[-+]?0*\.?0*(?:[eE]\d+)?\s*[a-z%]*$")
_SHARE = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*%?\s*$")
_LIGHTEST = {"lab": 99.9, "lch": 99.9, "oklab": 0.999, "oklch": 0.999}  # lightness of white, of spaces that have one
_TAKEN = {"(prefers-color-scheme:light)": True, "(prefers-color-scheme:dark)": False}
_FONT = re.compile(
    r"(?P<before>.*?)(?P<size>[\d.]+(?:px|pt|pc|mm|cm|in|em|ex|rem|%))(?:\s*/\s*\S+)?\s+(?P<family>.+)$", re.S
)


def local_name(name):
    """Return the name of an SVG tag without its namespace, or "" for those of other languages."""
    if not isinstance(name, str):
        return ""  # a comment
    space, _, local = name.rpartition("}")
    return local if space in ("", "{http://www.w3.org/2000/svg") else ""


@lru_cache(maxsize=4096)
def _read_declarations(text):
    """Return ([(name, value)] of the declarations without !important, the same of those with it)."""
    import tinycss2

    found = [], []
    for each in tinycss2.parse_blocks_contents(text or "", skip_comments=True, skip_whitespace=True):
        if each.type == "declaration":
            found[each.important].append((each.lower_name, tinycss2.serialize(each.value).strip()))
    return found


def _is_side(name, value):
    """True of a length that a style sheet may give a property of geometry; browsers take one without a unit."""
    match = _SIDE.fullmatch(value)
    return bool(match and (name in _SIGNED or match[1] != "-")) or value == "auto" and name in ("width", "height", "rx", "ry")


def _add_declaration(found, name, value, geometry):
    """Add a declaration to `found`, shorthands as their parts. `geometry`: the properties that are the element's own attributes."""
    if name == "font":
        match = _FONT.match(value)
        if match:
            found["font-size"], found["font-family"] = match["size"], match["family"]
            words = match["before"].split()
            found["font-style"] = next((word for word in words if word in ("italic", "oblique")), "normal")
            found["font-weight"] = next((word for word in words if word == "bold" or word.isdigit()), "normal")
        return
    for each in _SHORTHANDS.get(name, (name,)):
        if each in geometry or each in _OF_SHEETS:
            path = _PATH.fullmatch(value)
            if value in _KEYWORDS or (svg_transform.is_valid(each, value) if each in _OF_SHEETS else value == "none" or path if each == "d" else _is_side(each, value)):
                found[each] = path[2] if path else value
            else:
                found[UNREAD] = found.get(UNREAD, 0) + 1
        elif each in _KNOWN:
            found[each] = value


_SHOWN = 20  # letters of a sheet that is nested too deep


class Sheet:
    """The style sheets of a file, in their order: [text] or [(text, media)]."""

    def __init__(self, texts, root):
        self._rules = []  # (selector, order, body)
        self.unknown = []
        self.animations = 0
        self._of = {}  # id of an element: [(specificity, order, body)]
        for text in texts:
            text, media = (text, "") if isinstance(text, str) else text
            if self._media_applies(media):
                try:
                    self._read_sheet(text)
                except RecursionError:
                    self.unknown.append(f"{text.strip()[:_SHOWN]}…")
        if self._rules:
            self._match_rules(root)

    def _read_sheet(self, text):
        import tinycss2

        self._add_rules(tinycss2.parse_stylesheet(text, skip_comments=True, skip_whitespace=True))

    def _add_rules(self, rules):
        """Add rules of tinycss2 to `_rules`, as (selector, body): those of @media if a screen takes it, none of pseudo-elements. Counts keyframes in
        `animations`; rules that cannot be read go to `unknown`."""
        import cssselect2
        import tinycss2

        for rule in rules:
            if rule.type == "qualified-rule":
                try:
                    selectors = cssselect2.compile_selector_list(rule.prelude)
                except cssselect2.SelectorError:
                    self.unknown.append(tinycss2.serialize(rule.prelude).strip())
                    continue
                body = tinycss2.serialize(rule.content)
                if any(each.type in ("qualified-rule", "at-rule") for each in tinycss2.parse_blocks_contents(rule.content)):
                    self.unknown.append(tinycss2.serialize(rule.prelude).strip())  # rules in rules
                self._rules += [(each, body) for each in selectors if each.pseudo_element is None]
            elif rule.type == "at-rule" and rule.lower_at_keyword == "media" and rule.content is not None:
                if self._media_applies(tinycss2.serialize(rule.prelude)):
                    self._add_rules(tinycss2.parse_rule_list(rule.content, skip_comments=True, skip_whitespace=True))
            elif rule.type == "at-rule" and rule.lower_at_keyword in ("keyframes", "-webkit-keyframes"):
                self.animations += 1
            elif rule.type == "error" or rule.type == "at-rule" and rule.lower_at_keyword not in _SILENT:
                self.unknown.append(getattr(rule, "at_keyword", None) or rule.message)

    def _media_applies(self, media):
        """True if a screen takes rules of a list of media."""
        return not media.strip() or any(self._query_applies(each.strip().lower()) for each in media.split(","))

    def _query_applies(self, text):
        """True if a screen takes one query of a list of media. A query or feature that is not known goes to `unknown` and does not hold."""
        match = _QUERY.match(text)
        if match is None or match[2] is None and match[3] is None:
            self.unknown.append(f"@media {text}")
            return False
        taken = match[2] in (None, "all", "screen")
        for feature in re.split(r"\)\s*and\s*\(", match[3][1:-1]) if match[3] else ():
            known = _TAKEN.get(f"({re.sub(chr(92) + 's', '', feature)})")
            if known is None:
                self.unknown.append(f"@media {text}")
            taken = taken and bool(known)
        return taken != bool(match[1])

    def _match_rules(self, root):
        """Match all rules with all elements below `root`, once: `_of` gets the bodies of each element, the weakest first."""
        import cssselect2

        matcher = cssselect2.Matcher()
        for selector, body in self._rules:
            matcher.add_selector(selector, body)
        for wrapper in cssselect2.ElementWrapper.from_xml_root(root).iter_subtree():
            found = matcher.match(wrapper)
            if found:
                self._of[id(wrapper.etree_element)] = [body for _, _, _, body in found]  # the weakest first

    def style(self, element, inherited):
        """Return the properties of `element` within a parent of the properties `inherited`, as texts."""
        style = {name: value for name, value in inherited.items() if name in _INHERITED}
        own = {}
        geometry = _GEOMETRY.get(local_name(element.tag), frozenset())
        for name, value in element.attrib.items():
            if name == "transform" and _UNIT.search(value):
                own[UNREAD] = own.get(UNREAD, 0) + 1  # units are a style sheet's
            elif name in _KNOWN or name in geometry:
                own[name] = value.strip()
        bodies = [*self._of.get(id(element), ()), element.get("style", "")]
        for important in (False, True):
            for body in bodies:
                for name, value in _read_declarations(body)[important]:
                    _add_declaration(own, name, value, geometry)
        if own.get("dominant-baseline") == "no-change":
            del own["dominant-baseline"]
        for each, value in own.items():
            if value in _KEYWORDS:
                value = inherited.get(each) if value == "inherit" or value == "unset" and each in _INHERITED else None
                style.pop(each, None)
                if value is None and each in geometry:
                    value = ""  # the first value of the property, not that of the attribute
            if value is not None:
                style[each] = value
        return style


def font_size(text, parent):
    """Return a font-size in px; `parent`: that of the element around, which stays if it cannot be read or is negative."""
    if text in _SIZES:
        return _SIZES[text]
    size = parent * _STEPS[text] if text in _STEPS else length_px(text, parent, parent, parent)
    return size if size >= 0 else parent


def font_weight(text, parent):
    """Return a font-weight as a number, 1…1000; `parent`: that of the element around."""
    if text == "bolder":
        return next(weight for below, weight in ((350, 400), (550, 700), (math.inf, max(900, parent))) if parent < below)
    if text == "lighter":
        return next(weight for below, weight in ((100, parent), (550, 100), (750, 400), (math.inf, 700)) if parent < below)
    number = int(text) if text.isdigit() else 700 if text == "bold" else 400
    return number if 1 <= number <= 1000 else 400


def is_painted(style, what):
    """True if a "stroke" or a "fill" can be seen."""
    value = style.get(what, "none" if what == "stroke" else "black")
    if value in ("none", "transparent") or is_invisible(style.get(f"{what}-opacity")):
        return False
    if what == "stroke" and _ZERO.match(style.get("stroke-width", "1")):
        return False
    return _alpha_of(value) != 0


@lru_cache(maxsize=1024)
def _parse_colour(value):
    """Return tinycss2's colour of a text; None: a word that is no colour by itself (currentColor)."""
    from tinycss2.color4 import parse_color  # also #0008, rgb(0 0 0 / 50%), hsl(0 0% 100%)

    colour = parse_color(value)
    return None if isinstance(colour, str) else colour


def _alpha_of(value):
    colour = _parse_colour(value)
    return 1 if colour is None else colour.alpha or 0


def is_white(value):
    """True of a colour that is white in its own colour space, to a thousandth."""
    colour = _parse_colour(value)
    if colour is None or colour.space.startswith("xyz"):
        return False
    if colour.space in _LIGHTEST:
        return colour.coordinates[0] is not None and colour.coordinates[0] >= _LIGHTEST[colour.space]
    if colour.space in ("hsl", "hwb"):
        colour = colour.to("srgb")
    return min(each or 0 for each in colour.coordinates) > 0.999


def is_invisible(opacity):
    """True if the text of an opacity says 0 or less."""
    match = _SHARE.match(opacity or "")
    return bool(match) and float(match[1]) <= 0


def is_opaque(style):
    """True if nothing shines through a fill, as far as the element itself says."""
    if _alpha_of(style.get("fill", "black")) != 1:
        return False
    shares = [_SHARE.match(style.get(name, "1")) for name in ("opacity", "fill-opacity")]
    return all(match and (match[0].strip() == "100%" or float(match[1]) >= 1 and "%" not in match[0]) for match in shares)


def layer_of(group, order):
    """Return (number, name) of a group at the top."""
    label, name = group.get(_LABEL), group.get("id")
    for text in (label, name):
        digits = re.search(r"\d+", text or "")
        if digits:
            return max(1, int(digits[0])), label or name
    return order, label or name
