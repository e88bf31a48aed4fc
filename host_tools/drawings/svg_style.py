"""Styles of an SVG file: attributes, style sheets and `style` of an element, and the properties it inherits.

    sheet = Sheet([".st0{stroke:#000}"])
    style = sheet.style(element, inherited)         # {"stroke": "#000", …}

Supports the properties that decide whether, where and how an outline is drawn, and selectors of one element: `*`, `rect`,
`.class`, `#id`, `rect.class`, in lists. Other selectors go to `unknown` and match nothing.
"""

import re

_LABEL = "{http://www.inkscape.org/namespaces/inkscape}label"
_INHERITED = frozenset(
    "visibility fill stroke stroke-width stroke-dasharray stroke-dashoffset stroke-linecap clip-rule marker-start "
    "marker-mid marker-end font-family font-size font-style font-weight text-anchor letter-spacing white-space "
    "writing-mode".split()
)
_OWN = frozenset("display clip-path mask overflow dominant-baseline shape-inside".split())
_KNOWN = _INHERITED | _OWN
_SHORTHANDS = {"marker": ("marker-start", "marker-mid", "marker-end")}
_COMMENT = re.compile(r"/\*.*?\*/|<!--|-->", re.S)
_RULE = re.compile(r"([^{}]+)\{([^{}]*)\}")
_SIMPLE = re.compile(r"(\*|[\w-]+)?((?:[.#][\w-]+)*)$")
_FONT = re.compile(
    r"(?P<before>.*?)(?P<size>[\d.]+(?:px|pt|pc|mm|cm|in|em|ex|rem|%))(?:\s*/\s*\S+)?\s+(?P<family>.+)$", re.S
)


def local_name(name):
    """The name of an SVG tag without its namespace, or "" for those of other languages."""
    if not isinstance(name, str):
        return ""  # a comment
    space, _, local = name.rpartition("}")
    return local if space in ("", "{http://www.w3.org/2000/svg") else ""


def declarations(text):
    """{"stroke": "red", …} of "stroke: red; …"."""
    found = {}
    for part in text.split(";"):
        name, colon, value = part.partition(":")
        if colon:
            _declare(found, name.strip().lower(), value.replace("!important", "").strip())
    return found


def _declare(found, name, value):
    if name == "font":
        match = _FONT.match(value)
        if match:
            found["font-size"], found["font-family"] = match["size"], match["family"]
            words = match["before"].split()
            found["font-style"] = next((word for word in words if word in ("italic", "oblique")), "normal")
            found["font-weight"] = next((word for word in words if word == "bold" or word.isdigit()), "normal")
        return
    for each in _SHORTHANDS.get(name, (name,)):
        if each in _KNOWN:
            found[each] = value


class Sheet:
    """The style sheets of a file, in their order."""

    def __init__(self, texts):
        self._rules = []  # (specificity, order, tag, ids, classes, declarations)
        self.unknown = []
        for text in texts:
            for selectors, body in _RULE.findall(_COMMENT.sub("", text)):
                found = declarations(body)
                for selector in selectors.split(","):
                    if found:
                        self._add(selector.strip(), found)
        self._rules.sort(key=lambda rule: rule[:2])

    def _add(self, selector, found):
        match = _SIMPLE.match(selector)
        if not match:
            if selector and selector[0] != "@" and ":" not in selector:  # a font, a mouse pointer: nothing to draw
                self.unknown.append(selector)
            return
        tag = match[1] if match[1] != "*" else None
        marks = re.findall(r"[.#][\w-]+", match[2])
        ids = {mark[1:] for mark in marks if mark[0] == "#"}
        classes = {mark[1:] for mark in marks if mark[0] == "."}
        specificity = (len(ids), len(classes), tag is not None)
        self._rules.append((specificity, len(self._rules), tag, ids, classes, found))

    def style(self, element, inherited):
        """The properties of `element` within a parent of the properties `inherited`, as texts."""
        style = {name: value for name, value in inherited.items() if name in _INHERITED}
        own = {}
        for name, value in element.attrib.items():
            if name in _KNOWN:
                own[name] = value.strip()
        tag, name = local_name(element.tag), element.get("id")
        classes = set(element.get("class", "").split())
        for _, _, wanted, ids, marks, found in self._rules:
            if wanted in (None, tag) and ids <= {name} and marks <= classes:
                own.update(found)
        own.update(declarations(element.get("style", "")))
        for each, value in own.items():
            if value == "inherit":
                value = inherited.get(each)
            if value is not None:
                style[each] = value
        return style


def layer_of(group, order):
    """Number and name of a group at the top."""
    label, name = group.get(_LABEL), group.get("id")
    for text in (label, name):
        digits = re.search(r"\d+", text or "")
        if digits:
            return max(1, int(digits[0])), label or name
    return order, label or name
