"""`passo prove`: the board measures itself, and says whether it does what the documents promise."""

import os
import signal
import sys
import threading
from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools.cli.flash import check_port
from host_tools.failure import Failure
from host_tools.language import _
from host_tools.resources import version


def prove(
    port: Annotated[Optional[str], typer.Option("--port", help="Serial port of the board (passo ports).")] = None,
    emulated: Annotated[Optional[str], typer.Option("--emulated", metavar="BOARD", help="Try it on an emulated Pico with this board file.")] = None,
    uf2: Annotated[Optional[Path], typer.Option("--uf2", help="Passo's UF2 for the emulated Pico; MicroPython's unless given.")] = None,
    yes_drivers: Annotated[
        bool, typer.Option("--yes-drivers", help="Drive STEP and DIR without asking: the drivers are unplugged, or their enable is wired.")
    ] = False,
    json: Annotated[Optional[Path], typer.Option("--json", help="Write the report as JSON.")] = None,
    report: Annotated[Optional[Path], typer.Option("--report", help="Write the report as text, for an issue.")] = None,
    picture: Annotated[Optional[Path], typer.Option("--picture", help="Write a picture of the timings, .png.")] = None,
    lines: Annotated[
        bool, typer.Option("--lines", help="For programs: print each row as a line of JSON once it is measured, ask nothing, and end when standard input ends.")
    ] = False,
    analyser: Annotated[
        Optional[Path], typer.Option("--analyser", metavar="FILE", help="Be a logic analyser of eight pins instead: write what they do, .vcd or .sr (PulseView).")
    ] = None,
    first_pin: Annotated[int, typer.Option("--first-pin", help="--analyser: GPIO of the first channel.", min=0, max=22)] = 2,
    rate: Annotated[float, typer.Option("--rate", help="--analyser: samples a second, in MHz.", min=0.001, max=25)] = 25,
    trigger: Annotated[
        Optional[str], typer.Option("--trigger", help="--analyser: begin at rise:PIN, fall:PIN or word:LEVELS of the first channels (word:101).")
    ] = None,
    play: Annotated[bool, typer.Option("--play", help="--analyser: let the axes of the board file move there and back; else pins are only looked at.")] = False,
):
    """Let a board measure itself: clock, flash, memory, golden jobs, link, edges on its pins, emergency input, watchdog.

    Takes some two minutes. The motors' current stays off. Nothing of the board is changed; at its end it starts anew. Exit status 1 if anything is worse than promised.

    Example: passo prove --port /dev/ttyACM0

    Example: passo prove --emulated router_3axis --picture prove.png

    Example: passo prove --port /dev/ttyACM0 --analyser seen.vcd --first-pin 2 --trigger rise:2
    """
    from host_tools.prove.analyser import Wanted

    if (port is None) == (emulated is None):
        raise Failure("which board? Give --port, or --emulated BOARD")
    wanted = Wanted.from_words(analyser, first_pin, rate, trigger, play) if analyser else None
    if lines:
        end_with_stdin()
    connection, raw = connect_board(port, emulated, uf2, named=not wanted or play)
    with connection as board:
        pins = yes_drivers or not lines and (bool(emulated) or (not wanted or play) and may_drive_pins(raw))
        if wanted:
            print(wanted.record_to_file(board, raw, pins))
            return
        worse = measure_board(board, raw, pins, report, json, picture, lines)
    if worse:
        raise typer.Exit(1)


def connect_board(port, emulated, uf2, named):
    """Return (connection, the board file's table). `named` False: the table is {} if the board has none. Raises Failure."""
    from host_tools import boards
    from host_tools.prove.connection import EmulatedBoard, PortBoard, Silent, board_file_of

    if emulated:
        raw = boards.load(emulated)
        if raw.get("chip") != "rp2040":
            raise Failure("an RP2040 is emulated, and the board file is for {}", raw.get("chip"))
        return EmulatedBoard(emulated, uf2), raw
    check_port(port)
    connection = PortBoard(port)
    try:
        return connection, board_file_of(connection)
    except Failure as failure:
        if named or isinstance(failure, Silent):
            raise
        return connection, {}


def measure_board(board, raw, pins, report, json, picture, lines=False):
    """Measure the board, show the rows, and write the reports. Takes about two minutes. True if anything is worse than promised."""
    from host_tools.prove import report as reports
    from host_tools.prove.promises import WORSE
    from host_tools.prove.proof import Proof

    proof = Proof(board, raw, pins)
    header = _("Passo {}: {} on {}", version(), raw["name"], board.name)
    rows = list(reports.as_lines(proof, header) if lines else rows_with_progress(proof))
    if lines:
        print(reports.last_line(rows, header), flush=True)
    else:
        reports.print_report(rows, header)
    if report:
        with open(report, "w", encoding="utf-8") as file:
            reports.print_report(rows, header, file)
    if json:
        json.write_text(reports.as_json(rows, {"passo": version(), "board": raw["name"], "emulated": board.emulated}), encoding="utf-8")
    if picture:
        reports.draw_picture(picture, proof.timings)
    return any(row.verdict == WORSE for row in rows)


def may_drive_pins(raw):
    """True if the pins of STEP and DIR may be driven: the user is asked at a terminal."""
    from passo.steps.wiring import word_pins
    from passo.config.boardfile import check

    pins = ", ".join(f"GPIO{pin}" for pin in word_pins(check(raw))[:-1])
    question = _("Steps will appear on {}. Enable stays off, but are the drivers unplugged, or is their enable wired? Then y", pins)
    if not is_terminal():
        print(_("no terminal to ask: rows that need pins are left out. --yes-drivers drives them"))
        return False
    return typer.confirm(question)


def end_with_stdin():
    """Interrupt this program once standard input ends: the program that started it has closed the pipe, or has died."""

    def wait_for_end():
        """Read standard input to its end, then interrupt this process."""
        while os.read(0, 4096):
            pass
        os.kill(os.getpid(), signal.SIGINT)

    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's job in the background ignores it
    threading.Thread(target=wait_for_end, daemon=True).start()


def is_terminal():
    """True if standard input is a terminal."""
    return sys.stdin.isatty()


def rows_with_progress(proof):
    """Yield the rows of a proof as they are measured; show a progress bar on stderr."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    from host_tools.prove.proof import PARTS

    with Progress(TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn(), console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=len(PARTS))
        for title, rows in proof.parts():
            bar.update(task, description=title)
            yield from rows
            bar.advance(task)
