"""`passo interlock`: the table of a board file's interlock, as a truth table and as a picture."""

from itertools import product
from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools import boards
from host_tools.failure import Failure, reason
from host_tools.language import _

MOST_INPUTS = 12  # of one row: 4096 lines


class Table:
    """Rows of a board file's interlock, and the masks that the firmware makes of them.

    table = Table(boards.load("mill_2004"))
    table.rows["hx"].is_true({"bxb": 0, …})
    """

    def __init__(self, board):
        """Take the rows of a board file, a dict. Raises Failure if it has no interlock, BoardError if it is wrong."""
        from passo.options.interlock import manifest_table
        from passo.config.boardfile import check

        section = board.get("interlock")
        if not section:
            raise Failure("board {} has no interlock", board.get("name"))
        self.board = check(board)
        self.bits = manifest_table.gate_bits(self.board)
        self.inputs = [item["name"] for item in self.board["inputs"]]
        self.signals = section.get("signals", {})
        texts = dict(section.get("rows", {}))
        self.rows = {name: Row(name, manifest_table.parse_row(text, name)) for name, text in texts.items()}
        self.limits = section.get("limits", {})
        self.masks = self.board["additions"].masks

    def rows_of_gates(self):
        """Return {name: Row} of the directions, tool and outputs that the firmware gates: in inputs only, without signals, as in its masks."""
        from passo.options.interlock.steps_viper import PERMIT_FIELDS, PERMIT_FIRST, PERMIT_GATED

        found = {}
        table = self.masks["table"]
        for name, bit in self.bits.items():
            if table[PERMIT_GATED] & bit:
                products = []
                for at in range(PERMIT_FIRST, len(table), PERMIT_FIELDS):
                    care, value, bits = table[at : at + PERMIT_FIELDS]
                    if bits & bit:
                        products.append({self.inputs[i]: bool(value >> i & 1) for i in range(len(self.inputs)) if care >> i & 1})
                found[name] = Row(name, products)
        return found


class Row:
    """A row of an interlock: true if one of its products is. `products`: [{input or signal: True if it must be active}]."""

    def __init__(self, name, products):
        self.name = name
        self.products = products
        self.names = sorted({each for product in products for each in product})

    def is_true(self, states):
        """True if a product of the row is true. `states`: {input or signal: 0 or 1}."""
        return any(all(states[name] == wanted for name, wanted in product.items()) for product in self.products)

    def formula(self):
        """Return the row as a board file has it: products joined by |, inputs by &, ! before one that must be inactive."""
        return " | ".join(
            " & ".join(name if wanted else "!" + name for name, wanted in product.items()) for product in self.products
        )

    def truth_lines(self):
        """Yield (levels of its inputs, value 0 or 1) of every combination: 2ⁿ of n inputs."""
        for levels in product((0, 1), repeat=len(self.names)):
            yield levels, int(self.is_true(dict(zip(self.names, levels))))


def truth_table(row):
    """Return the lines of a row's truth table; of more than MOST_INPUTS inputs only its formula."""
    if len(row.names) > MOST_INPUTS:
        return [f"{row.name} = {row.formula()}", _("    {} inputs: too many for a table", len(row.names))]
    lines = [f"{row.name} = {row.formula()}", "    " + " ".join(row.names) + f"  {row.name}"]
    for levels, value in row.truth_lines():
        lines.append("    " + " ".join(f"{level:>{len(name)}}" for name, level in zip(row.names, levels)) + f"  {value:>{len(row.name)}}")
    return lines


def draw_table(table, path):
    """Draw a picture of the gated directions, tool and outputs against the inputs. Each product of a row is a line of marks: filled,
    the input must be active; empty, it must not."""
    from host_tools.figures import pyplot

    gated = table.rows_of_gates()
    rows = [(name, number, product) for name, row in gated.items() for number, product in enumerate(row.products)]
    names = [name for name in table.inputs if any(name in product for _, _, product in rows)]
    plt = pyplot()
    figure, axes = plt.subplots(figsize=(1.6 + 0.55 * len(names), 1.4 + 0.38 * len(rows)))
    shade = False
    for line, (name, number, states) in enumerate(rows):
        if number == 0:
            shade = not shade
        if shade:
            axes.axhspan(line - 0.5, line + 0.5, color="0.94", zorder=0)
        for state in states:
            at = names.index(state)
            axes.plot(at, line, "s", ms=11, mec="black", mfc="black" if states[state] else "white", zorder=2)
    axes.set_xticks(range(len(names)), names, rotation=60, ha="left")
    axes.set_yticks(range(len(rows)), [name if number == 0 else _("or") for name, number, _ in rows])
    axes.set_xlim(-0.6, len(names) - 0.4)
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.xaxis.tick_top()
    axes.tick_params(length=0)
    axes.grid(color="0.85", lw=0.6, zorder=1)
    axes.set_title(_("{}: allowed if every ■ is active and every □ is not", table.board["name"]), pad=12, fontsize=10)
    for spine in axes.spines.values():
        spine.set_visible(False)
    figure.savefig(path, dpi=110, bbox_inches="tight")
    plt.close(figure)


def interlock(
    board: Annotated[str, typer.Argument(help="Name of a file of boards/, or the path of a board file.")],
    rows: Annotated[bool, typer.Option("--rows", help="The board file's rows, not what the pins make of them.")] = False,
    out: Annotated[Optional[Path], typer.Option("--out", help="Draw the table: a PNG, SVG or PDF file.")] = None,
):
    """Print the truth table of a board file's interlock: when each direction, output and the tool is allowed.

    Example: passo interlock mill_2004

    Example: passo interlock mill_2004 --rows

    Example: passo interlock mill_2004 --out /tmp/mill.png
    """
    from passo.config.board_error import BoardError

    try:
        table = Table(boards.load(board))
    except BoardError as error:
        raise Failure("{}: {}", board, reason(error)) from None
    for row in (table.rows if rows else table.rows_of_gates()).values():
        print("\n".join(truth_table(row)), end="\n\n")
    if out:
        draw_table(table, out)
        print(_("drawn: {}", out))
