"""Faults of an SVG file are named by the element they are in.

    with name_faults(path, element):
        …       # what goes wrong with its numbers becomes a Failure that names the element
    page.left_out[N_("…")] += count_unreadable(element)       # attributes that are no numbers: as in a browser, they are as if missing
"""

import contextlib
import re

from host_tools.drawings.svg_geometry import TooFar, are_lengths
from host_tools.drawings.svg_style import local_name
from host_tools.failure import Failure, reason


def name_of(element):
    """Return an element's name for an error, as in the file: <path id="a">."""
    name = element.get("id")
    return f'<{local_name(element.tag)} id="{name}">' if name else f"<{local_name(element.tag)}>"


_LENGTHS = frozenset("x y x1 y1 x2 y2 cx cy r rx ry width height dx dy rotate startOffset textLength viewBox stroke-dasharray stroke-dashoffset font-size".split())
_BY_LETTERS = re.compile(r"\d(rem|ex|ch)\b")
_WORDS = frozenset("auto none inherit initial medium small large smaller larger x-small x-large xx-small xx-large".split())


def count_unreadable(element):
    """Count the attributes of an element that should be numbers and are not: nan, inf, words."""
    return sum(text.strip() not in _WORDS and not are_lengths(text) for name, text in element.items() if name in _LENGTHS)


def count_by_letters(element):
    """Count the lengths of an element in a unit of letters that depends on more than their size."""
    return sum(bool(_BY_LETTERS.search(text)) for name, text in element.items() if name in _LENGTHS)


@contextlib.contextmanager
def name_faults(path, element):
    """Run the block; raise its TooFar, and errors of numbers, memory and depth, as a Failure that names the file and the element."""
    try:
        yield
    except TooFar as error:
        raise Failure("{}: {}: {} px is too far away for a drawing, or no number", path, name_of(element), error) from error
    except (ArithmeticError, ValueError, TypeError, MemoryError, RecursionError) as error:
        raise Failure("{}: {}: its numbers cannot be drawn: {}", path, name_of(element), reason(error)) from error
