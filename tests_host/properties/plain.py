"""Kernels without machine code: the functions of a firmware module compiled as ordinary Python, from the same text.

    walk = plain(line_viper)["walk"]
"""

MARKS = ("@micropython.viper\n", "@micropython.native\n")


def plain(module):
    """{name: function} of a module's text without its marks of machine code."""
    path = module.__file__
    if path.endswith(".mpy"):
        path = path[:-3] + "txt"  # beside compiled modules lie their texts
    with open(path) as file:
        text = file.read()
    for mark in MARKS:
        text = text.replace(mark, "")
    names = {"__name__": module.__name__ + "_plain", "ptr32": lambda array: array}
    exec(text, names)
    return names
