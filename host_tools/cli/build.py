"""`passo build`: the firmware of one board, compiled, with its sizes."""

from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools import boards
from host_tools.build.budget import check_module
from host_tools.build.tree import MARCH, build_tree, default_out, kernels_of, write_package
from host_tools.failure import Failure, reason
from host_tools.kernels.build import c_of
from host_tools.kernels.module import ARCHITECTURE
from host_tools.language import _
from host_tools.switches import print_cautions


def print_sizes(title, rows):
    """Print a table of rows (name, bytes of source, bytes on the board), with a sum below."""
    from rich.console import Console
    from rich.table import Table

    table = Table(_("file"), title=title)
    for heading in (_("source"), _("on the board")):
        table.add_column(heading, justify="right")
    for row in rows:
        table.add_row(row[0], *[f"{size:,}" for size in row[1:]])
    table.add_section()
    table.add_row(_("bytes in all"), *[f"{sum(column):,}" for column in list(zip(*rows))[1:]])
    Console().print(table)


def check_board(name):
    """Return the checked board of a board file. Raises Failure if it is wrong."""
    from passo.config.board_error import BoardError
    from passo.config.boardfile import check

    try:
        return check(boards.load(name))
    except BoardError as error:
        raise Failure("{}: {}", name, reason(error)) from None


def print_budget(name):
    """Print how much of its chip a board file uses. Raises Failure if the board file is wrong."""
    from host_tools.build.budget import budget_rows

    rows = budget_rows(check_board(name))
    width = max(len(title) for title, _ in rows)
    for title, text in rows:
        print(f"{title:<{width}}  {text}")


def print_kernel(board, name):
    """Print a kernel of the board's build as C. Raises Failure if no kernel has that name."""
    program, groups = kernels_of(board)
    text = c_of(program, groups, name)
    if not text:
        raise Failure("{} has no kernel {}; there are {}", board, name, ", ".join(sorted({kernel.name for kernel in program.kernels.values()})))
    print(text)


def print_kernels(board, march, by):
    """Print which compilers compiled the kernels; if only viper did, the time and memory that costs."""
    march = march or MARCH[boards.load(board)["chip"]]
    if by:
        print(_("Kernels compiled by {}.", ", ".join(by)))
    elif march in ARCHITECTURE:
        print(_("Kernels compiled by viper: lines take 1.6 times as long, and 15 kB more memory. pip install 'passo[kernels]' has a compiler."))
    else:
        print(_("Kernels compiled by viper: nothing else compiles for {}.", march))


def build(
    board: Annotated[str, typer.Option("--board", help="Name of a file of boards/, or the path of a board file.")],
    out: Annotated[Optional[Path], typer.Option("--out", help="Folder to build in; build/NAME unless given.")] = None,
    march: Annotated[Optional[str], typer.Option("--march", help="Instruction set, instead of the chip's own.")] = None,
    show: Annotated[Optional[str], typer.Option("--show", help="Print a kernel as C, and build nothing.")] = None,
):
    """Compile the firmware of one board; show its sizes, and the pins, PIO and shift registers that the board file uses.

    Example: passo build --board plotter_2014

    Example: passo build --board mine/router.py --out /tmp/router --march armv7emsp

    Example: passo build --board router_3axis --show plan_block
    """
    if show:
        print_kernel(board, show)
        return
    check_module(check_board(board), board)
    out = out or default_out(board)
    by = []
    rows = build_tree(board, out, march, by=by)
    write_package(out)
    print_sizes(_("{} in {}", board, out), rows)
    print_kernels(board, march, by)
    print_budget(board)
    print_cautions(boards.load(board))
