"""Runs the machine of a board file that main.py has loaded. Functions of their own import what only the start needs."""

import sys

from passo.config.board_error import BoardError, by_options


def check_board(board):
    from passo.config.boardfile import check

    return check(board)


def import_all(board):
    from passo.machine_builder import load_all

    load_all(board)


def main(Start, stamp):
    """Check the board file, make its machine and run it until it ends; print and log errors, and leave the outputs safe. `Start`: the chip's class;
    `stamp`: of the build, "" if it has none."""
    raw = getattr(sys.modules.get("board"), "BOARD", None)
    start = Start(by_options(raw))
    start.history()
    if raw is None or not start.ready():
        return
    app = port = error = None
    start.begin_loading()
    try:
        board = check_board(raw)
        raw = None
        box = getattr(board.get("additions"), "box", None)
        if box:  # a black box that a reset has left, before its memory is used anew
            __import__(box[0], None, None, ("save_left_box",)).save_left_box(*box[1:])
        start.load(board)
        from passo.app import App
        from passo.config.journal import FileSlots

        import_all(board)
        said = start.finish_loading()
        port = start.port(board)
        app = App(board, port, None, FileSlots("settings"))
        said = ", ".join([part for part in (said, stamp and "build " + stamp) if part])
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
