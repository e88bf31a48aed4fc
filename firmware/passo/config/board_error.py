"""What is wrong with a board file, and what no message could show."""

from micropython import const

_DEPTH = const(12)  # of lists in dicts in lists …; the rules have fewer
OF_OUTPUT = "output_"  # how the option of an output of a name is called
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


def names_of(outputs):
    """What each output is, a word: its name, or what follows p0_ … in it. Items may be anything."""
    names = [item["name"].rpartition("_")[2] for item in outputs if isinstance(item, dict) and isinstance(item.get("name"), str)]
    return [name for name in names if name.isalpha()]


def own_rules(board, rules):
    """The manifests of the options that the board file asks for, by their keys and by what its outputs are. Adds their RULES to `rules`.

    A manifest may have extend(rules), prepare(board), called before pins are checked, claims(board): [(pin, who)], has_bit(pin): True for an
    output that is no pin of the chip, and check(board)."""
    own = []
    outputs = board.get("outputs")
    names = names_of(outputs if isinstance(outputs, (list, tuple)) else ())
    for key in sorted([key for key in board if isinstance(key, str)]) + [OF_OUTPUT + name for name in names]:
        if key not in rules and "." not in key:
            try:
                module = __import__("passo.options.%s.manifest" % key, None, None, ("RULES",))
            except ImportError:
                continue
            rules.update(module.RULES)
            own.append(module)
    return own
