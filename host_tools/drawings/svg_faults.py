"""What is wrong in an SVG file is told by the element it is in.

    with told(path, element):
        …       # what goes wrong with its numbers becomes a Failure that names the element
"""

import contextlib

from host_tools.drawings.svg_geometry import TooFar
from host_tools.drawings.svg_style import local_name
from host_tools.failure import Failure, reason


def name_of(element):
    """As in the file: <path id="a">."""
    name = element.get("id")
    return f'<{local_name(element.tag)} id="{name}">' if name else f"<{local_name(element.tag)}>"


@contextlib.contextmanager
def told(path, element):
    try:
        yield
    except TooFar as error:
        raise Failure("{}: {}: {} px is too far away for a drawing, or no number", path, name_of(element), error) from error
    except (ArithmeticError, ValueError, TypeError, MemoryError, RecursionError) as error:
        raise Failure("{}: {}: its numbers cannot be drawn: {}", path, name_of(element), reason(error)) from error
