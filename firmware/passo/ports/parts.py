"""Options' additions to a port: their manifests write the names of the modules into board["additions"]."""


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


def of_option(option, file):
    """Return an option's module, which has create()."""
    return _module("passo.options.%s.%s" % (option, file))


def _module(name):
    return __import__(name, None, None, ("create",))
