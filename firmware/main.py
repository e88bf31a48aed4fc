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


# Functions of their own import what only the start needs.


def load_safe_board():
    """Return the raw board file, whose outputs are inactive from here on; None if it cannot be read."""
    from passo.ports.safe import outputs, safe

    try:
        from board import BOARD
    except Exception as error:
        print("board.py cannot be read: %s: %s" % (type(error).__name__, error))
        return None
    safe(outputs(BOARD))
    return BOARD


if image and image.choose_package():
    STAMP, WHOLE = image.STAMP, image.whole()
else:
    STAMP = stamp_of("passo/stamp.txt")
    WHOLE = STAMP == stamp_of("stamp.txt")

if WHOLE:
    BOARD = load_safe_board()  # first: the rest takes seconds
    if sys.platform == "esp32":
        from passo.ports.esp32.start import Start
    else:
        if not (image and image.STAMP == STAMP):
            from passo.ports.rp2 import flash_code

            flash_code.begin()  # modules imported from here on stay in flash
            del flash_code
        from passo.ports.rp2.start import Start
    from passo.config.board_error import BoardError
    from passo.memory import forget

    image = None


def check_board(board):
    from passo.config.boardfile import check

    return check(board)


def import_all(board):
    """Save the black box left by a reset, then import all modules that the board wants."""
    box = getattr(board.get("additions"), "box", None)
    if box:  # a black box that a reset has left, before its memory is used anew
        __import__(box[0], None, None, ("save_left_box",)).save_left_box(*box[1:])
    from passo.machine_builder import load_all

    load_all(board)


def by_options(board):
    """Return a raw board file with the pins that its options give it, such as those of a parallel port."""
    try:
        sections = {key: value for key, value in board.items() if isinstance(value, dict) and "port_pins" in value}
        if sections:
            from passo.config.board_error import own_rules, rewritten

            return rewritten(board, own_rules(sections, {}))[0]
    except Exception:  # its check will say what is wrong
        pass
    return board


def main():
    """Check BOARD, build the app and run it until it ends; print and log errors, and leave the outputs safe."""
    global BOARD
    start = Start(by_options(BOARD))
    start.history()
    if BOARD is None or not start.ready():
        return
    app = port = error = None
    start.begin_loading()
    try:
        board = check_board(BOARD)
        BOARD = None
        manifests = [name for name in sys.modules if name[:14] == "passo.options." and ".manifest" in name]
        for name in ["board", "passo.config.boardfile", "passo.config.chip_pins"] + manifests:
            forget(name, True)
        start.keep(board)
        from passo.app import App
        from passo.config.journal import FileSlots

        start.load(board)
        import_all(board)

        said = start.finish_loading()
        port = start.port(board)
        lines = getattr(board.get("additions"), "lines", None)
        app = App(board, port, None, FileSlots("settings"), start.rooms)
        forget("passo.machine_builder")
        forget(lines)
        said = ", ".join([part for part in (said, STAMP and "build " + STAMP) if part])
        if said:
            print(said)
            app.controller.tell(said)
        start.run(app, port)
    except BoardError as wrong:
        print("board.py is wrong:", wrong)
    except KeyboardInterrupt:
        print("stopped")
    except MemoryError as full:
        print("board.py asks for more memory than there is: leave out a link, a language or store_points. grbl wants a Pico, not a Pico W: the page is then that of passo panel, on a PC")
        error = full
    except Exception as crash:
        error = crash
    start.end(app, port, error)


if WHOLE:
    main()
elif image and STAMP == image.STAMP:
    print("the UF2 here is not whole: copy it again. Hold BOOTSEL while you plug the board in: passo flash --uf2")
else:
    print("the firmware here is not whole: copying it was cut short, or it is of two builds. Flash it again: passo flash")
