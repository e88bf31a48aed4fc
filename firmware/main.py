"""Runs the machine of /board.py. Ways to the REPL: BOOTSEL or the input "repl" held at the start, Ctrl-C."""

import gc
import sys

# At the lower end of memory: given back when all is loaded, so that what comes and goes from then on is found a place at
# once. Behind all that stays, finding one takes more than half a millisecond.
room = bytearray(7_000)
gc.threshold(48_000)  # collect while importing: what stays lies close together; oftener costs a tenth of a second

from passo.control.board_error import BoardError
from passo.ports.start import forget

if sys.platform == "esp32":
    from passo.ports.esp32.start import Start
else:
    from passo.ports.rp2.start import Start


def checked(board):
    from passo.control.boardfile import check

    return check(board)


def main():
    global room
    try:
        from board import BOARD
    except Exception as error:
        print("board.py cannot be read: %s: %s" % (type(error).__name__, error))
        BOARD = None
    start = Start(BOARD)  # safe outputs first: the rest takes a second or two to load
    start.history()
    if BOARD is None or not start.wanted():
        return
    app = port = error = None
    if start.loading():
        room = None
    try:
        board = checked(BOARD)
        BOARD = None
        forget("board")
        forget("passo.control.boardfile")
        forget("passo.control.chip_pins")
        from passo.app import App
        from passo.control.journal import FileSlots

        port = start.port(board)
        app = App(board, port, None, FileSlots("settings"))
        forget("passo.machine_builder")
        room = None
        said = start.loaded()
        if said:
            print(said)
            app.tell(said)
        gc.collect()
        gc.threshold(-1)  # from here on only when memory is used up: a collection takes some 30 ms
        start.run(app, port)
    except BoardError as wrong:
        print("board.py is wrong:", wrong)
    except KeyboardInterrupt:
        print("stopped")
    except Exception as crash:
        error = crash
    start.end(app, port, error)


main()
