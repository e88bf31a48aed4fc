"""`passo wiring`: the connection of each pin, as a table and as a drawing."""

from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools.failure import Failure
from host_tools.language import _


def wiring(
    board: Annotated[str, typer.Argument(help="Board file: a name, or the path of a .py file.")],
    out: Annotated[Optional[Path], typer.Option("-o", "--out", help="Write a drawing instead, as SVG, for a sheet of A4.")] = None,
    whole: Annotated[bool, typer.Option("--whole", help="Print the whole board file instead, as a board gets it.")] = False,
):
    """Show how a board file is wired: each pin, and the driver, switch or relay that it goes to.

    The drawing has the module as it is seen from above, the drivers and motors, switches, tool and relays, and the way of the power
    through the emergency stop. `passo --lang pt wiring …` labels it in Portuguese.

    Examples:

        passo wiring router_3axis                    # the table
        passo wiring router_3axis --out router.svg   # the drawing: open it in a browser, print it
        passo wiring boards/mine.py -o mine.svg      # that of your own machine
        passo wiring boards/mine.py --whole          # if it is "like" another: all that the board gets
    """
    from host_tools import boards
    from host_tools.switches import print_cautions
    from passo.config.boardfile import check

    checked = check(boards.load(board))
    print_cautions(checked)
    if whole:
        if out is not None:
            raise Failure("--whole prints the board file; leave out --out")
        print(boards.board_py(board).decode(), end="")
        return
    if out is None:
        return _print_table(checked)
    from host_tools.wiring.drawing import wiring_svg

    if out.suffix.lower() != ".svg":
        raise Failure("the drawing is an SVG file: --out {}.svg, not {}", out.stem, out)
    out.write_text(wiring_svg(checked), encoding="utf-8")
    print(out)


def _print_table(board):
    """Print a row of each terminal of a checked board file."""
    from rich.console import Console
    from rich.table import Table

    from host_tools.wiring.table import wiring_rows

    table = Table(box=None, pad_edge=False, title=_("Wiring of {}", board["name"]), title_justify="left")
    for title in (_("pin"), _("position"), _("goes to"), _("terminal"), _("notes")):
        table.add_column(title)
    for row in wiring_rows(board):
        table.add_row(*row)
    Console().print(table, markup=False)
