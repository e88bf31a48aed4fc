"""`passo prove`: the board measures itself, and says whether it does what the documents promise."""

import ast
import sys
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
):
    """Let a board measure itself: clock, flash, memory, golden jobs, link, edges on its pins, emergency input, watchdog.

    Takes some two minutes. The motors' current stays off. Nothing of the board is changed; at its end it starts anew. Exit status 1 if anything is worse than promised.

    Example: passo prove --port /dev/ttyACM0

    Example: passo prove --emulated router_3axis --picture prove.png
    """
    from host_tools import boards
    from host_tools.prove import report as reports
    from host_tools.prove.connection import EmulatedBoard, PortBoard
    from host_tools.prove.promises import WORSE
    from host_tools.prove.proof import Proof

    if (port is None) == (emulated is None):
        raise Failure("which board? Give --port, or --emulated BOARD")
    if emulated:
        raw = boards.load(emulated)
        if raw.get("chip") != "rp2040":
            raise Failure("an RP2040 is emulated, and the board file is for {}", raw.get("chip"))
        connection = EmulatedBoard(emulated, uf2)
        pins = True
    else:
        check_port(port)
        connection = PortBoard(port)
        raw = board_file_of(connection)
        pins = yes_drivers or asked(raw)
    with connection as board:
        proof = Proof(board, raw, pins)
        rows = list(watched(proof))
    header = _("Passo {}: {} on {}", version(), raw["name"], connection.name)
    reports.show(rows, header)
    if report:
        with open(report, "w", encoding="utf-8") as file:
            reports.show(rows, header, file)
    if json:
        json.write_text(reports.as_json(rows, {"passo": version(), "board": raw["name"], "emulated": connection.emulated}), encoding="utf-8")
    if picture:
        reports.picture(picture, proof.timings)
    if any(row.verdict == WORSE for row in rows):
        raise typer.Exit(1)


def board_file_of(board):
    """The table of /board.py. Raises Failure if there is none."""
    board.fresh()
    try:
        return ast.literal_eval(board.exec("from board import BOARD\nprint(repr(BOARD))"))
    except Failure as failure:
        raise Failure("there is no board file on {}: {}. passo flash puts one there", board.name, failure) from None


def asked(raw):
    """Whether the pins may be driven."""
    from passo.steps.wiring import word_pins
    from passo.config.boardfile import check

    pins = ", ".join(f"GPIO{pin}" for pin in word_pins(check(raw))[:-1])
    question = _("Steps will appear on {}. Enable stays off, but are the drivers unplugged, or is their enable wired? Then y", pins)
    if not sys.stdin.isatty():
        print(_("no terminal to ask: rows that need pins are left out. --yes-drivers drives them"))
        return False
    return typer.confirm(question)


def watched(proof):
    """The rows, with a bar for whoever waits."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    from host_tools.prove.proof import PARTS

    with Progress(TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn(), console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=len(PARTS))
        for title, rows in proof.parts():
            bar.update(task, description=title)
            yield from rows
            bar.advance(task)
