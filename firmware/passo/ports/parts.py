"""Options' additions to a port: their manifests write the names of the modules into board["additions"]. And modules of the chip's own."""

import sys


def load(board, file=None):
    """[(name, module)] of the parts, whose modules have create(). `file`: the name of the option's file to take instead, for all but a bank."""
    found = []
    parts = getattr(board.get("additions"), "parts", {})
    for name in sorted(parts):
        module = parts[name]
        if file and name == "bank":
            continue
        if file:
            module = module.rpartition(".")[0] + "." + file
        found.append((name, _module(module)))
    return found


def player(board):
    """Return an option's module that makes the player of the words; None: the port's own does."""
    name = getattr(board.get("additions"), "player_module", None)
    return _module(name) if name else None


def of_line(port):
    """Return what the chip has of its own for lines of a link's port, such as ports/rp2/line_usb.py, which has create(); None: nothing."""
    try:
        return _module("passo.ports.%s.line_%s" % (sys.platform, port.rstrip("01")))
    except ImportError:
        return None


def of_option(option, file):
    """Return an option's module, which has create()."""
    return _module("passo.options.%s.%s" % (option, file))


def _module(name):
    return __import__(name, None, None, ("create",))
