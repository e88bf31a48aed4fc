"""The `passo` command: registers the verbs, each of which lives in its own module."""

import sys

import typer

from host_tools.build import build
from host_tools.check import check
from host_tools.draw import draw
from host_tools.emulate import emulate
from host_tools.failure import Failure
from host_tools.flash import flash
from host_tools.keys import keys
from host_tools.link import link
from host_tools.log import log
from host_tools.plot import plot
from host_tools.ports import ports
from host_tools.pulses import app as pulses
from host_tools.send import send
from host_tools.settings import settings
from host_tools.stream import stream
from host_tools.torch import app as torch
from host_tools.virtual_board import board

app = typer.Typer(
    help="Passo: a motion controller for stepper machines. Draw, send, watch, and try it all on a virtual board.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

for _verb in (board, emulate, draw, send, stream, keys, check, settings, link, log, plot, ports, build, flash):
    app.command()(_verb)
app.add_typer(pulses, name="pulses")
app.add_typer(torch, name="torch")


def main():
    """Run `passo`; a Failure, or what the system refuses, is one line on stderr and exit status 1."""
    try:
        app()
    except Failure as failure:
        print(f"passo: {failure}", file=sys.stderr)
        sys.exit(1)
    except OSError as refusal:
        where = f"{refusal.filename}: " if refusal.filename else ""
        print(f"passo: {where}{refusal.strerror or refusal}", file=sys.stderr)
        sys.exit(1)


if __name__ == "__main__":
    main()
