"""What is wrong with a board file, and what no message could show."""

from micropython import const

_DEPTH = const(12)  # of lists in dicts in lists …; the rules have fewer
_LONGEST = const(1000)  # characters of a text


class BoardError(Exception):
    """The board file is wrong: one line that says where, and what would be right."""


def want_input(board, who, name):
    """Raise BoardError if the board has no input `name`. `who`: the board-file key that refers to it."""
    if name not in [item["name"] for item in board["inputs"]]:
        raise BoardError("%s: there is no input %r" % (who, name))


def check_shape(value, depth=_DEPTH):
    """Raise BoardError if a value is nested too deep, or within itself, or has a text that is too long."""
    if isinstance(value, str) and len(value) > _LONGEST:
        raise BoardError("a text of %d characters, which begins with %r, is too long" % (len(value), value[:40]))
    if not isinstance(value, (dict, list, tuple)):
        return
    if not depth:
        raise BoardError("a list or dict is nested too deep")
    for each in value.values() if isinstance(value, dict) else value:
        check_shape(each, depth - 1)


def own_rules(board, rules):
    """The manifests of the options that the board file asks for, by their keys. Adds their RULES to `rules`.

    A manifest may have prepare(board), called before pins are checked, claims(board): [(pin, who)], and check(board)."""
    own = []
    for key in sorted([key for key in board if isinstance(key, str)]):
        if key not in rules and "." not in key:
            try:
                module = __import__("passo.options.%s.manifest" % key, None, None, ("RULES",))
            except ImportError:
                continue
            rules.update(module.RULES)
            own.append(module)
    return own
