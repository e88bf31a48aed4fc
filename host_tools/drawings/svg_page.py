"""The elements of an SVG file, and the size of its page.

    root = root_of("map.svg")
    width, height = page_size(root, style)      # px; `style`: properties of the root
    box = view_box(root)                        # [x, y, width, height] or None
"""

import re
from pathlib import Path
from xml.etree import ElementTree

from host_tools.drawings import svg_geometry
from host_tools.drawings.svg_style import local_name
from host_tools.failure import Failure

_DEFAULT_PX = 1000.0  # of a file that says neither its size nor its viewBox
_PICTURE = re.compile(rb"(data:[\w/+.;=-]*,)[^\"'<>)]{200,}")  # which nobody draws, in an attribute or url()


def root_of(path):
    """Return the root element of an SVG file. Raises Failure if the file is not there, or is no SVG."""
    try:
        # In one piece: expat reads a picture of n parts n times, if it gets them one by one.
        root = ElementTree.fromstring(_PICTURE.sub(rb"\1", Path(path).read_bytes()))
    except FileNotFoundError as error:
        raise Failure("no file {}", path) from error
    except (OSError, ElementTree.ParseError, ValueError, LookupError) as error:
        raise Failure("{} is not an SVG file that can be read: {}", path, error) from error
    if local_name(root.tag) != "svg":
        raise Failure("{} is not an SVG file: it begins with <{}>", path, root.tag)
    return root


def page_size(root, style):
    """Return width and height in px; from the viewBox if they are missing or in %. Raises TooFar."""
    return tuple(map(svg_geometry.check_bound, _size_px(root, style)))


def _size_px(root, style):
    """Return width and height of the page in px, of the style, else of the attributes. A missing one follows from the viewBox, or is _DEFAULT_PX.
    Raises TooFar."""
    box = view_box(root)
    width, height = (svg_geometry.length_px(style.get(name), default=svg_geometry.length_px(root.get(name), default=None)) for name in ("width", "height"))
    shape = (box[2], box[3]) if box else (_DEFAULT_PX, _DEFAULT_PX)
    if width is None and height is None:
        return shape
    if width is None:
        return (height * shape[0] / shape[1] if box else _DEFAULT_PX), height
    if height is None:
        return width, (width * shape[1] / shape[0] if box else _DEFAULT_PX)
    return width, height


def view_box(element):
    box = svg_geometry.read_numbers(element.get("viewBox"))
    return box if len(box) == 4 and box[2] > 0 and box[3] > 0 else None
