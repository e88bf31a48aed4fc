"""Runs the machine of /board.py. Ways to the REPL: BOOTSEL or the input "repl" held at the start, Ctrl-C.

A build has its stamp in passo/stamp.txt, and in stamp.txt, which is copied last: where they differ, the files here are not those of
one build, and none is run. In Passo's UF2 all of it is frozen: passo_image knows whether it is whole.
"""

import sys

try:
    import passo_image as image
except ImportError:  # stock MicroPython
    image = None


def stamp_of(path):
    try:
        with open(path) as file:
            return file.read().strip()
    except OSError:
        return ""


def load_safe_board():
    """Load the board file, whose outputs are inactive from here on. Prints why if it cannot be read."""
    from passo.ports.safe import outputs, safe

    try:
        from board import BOARD
    except Exception as error:
        print("board.py cannot be read: %s: %s" % (type(error).__name__, error))
    else:
        safe(outputs(BOARD))


def load_start(frozen):
    """Return the class Start of this chip; a chip may have another one, in the folder `stock`, for code that is not `frozen`."""
    port = "passo.ports.%s." % sys.platform
    try:
        return __import__(port + ("start" if frozen else "stock.start"), None, None, ("Start",)).Start
    except ImportError:
        return __import__(port + "start", None, None, ("Start",)).Start


if image and image.choose_package():
    STAMP, WHOLE = image.STAMP, image.whole()
else:
    STAMP = stamp_of("passo/stamp.txt")
    WHOLE = STAMP == stamp_of("stamp.txt")

if WHOLE:
    load_safe_board()  # first: the rest takes seconds
    Start = load_start(image and image.STAMP == STAMP)
    from passo.run import main

    image = None
    main(Start, STAMP)
elif image and STAMP == image.STAMP:
    print("the UF2 here is not whole: copy it again. Hold BOOTSEL while you plug the board in: passo flash --uf2")
else:
    print("the firmware here is not whole: copying it was cut short, or it is of two builds. Flash it again: passo flash")
