"""`passo link`: shows which link of a board commands, and hands the command over."""

from typing import Annotated, Optional

import typer

from host_tools.cli.options import AnyBaud, Port
from host_tools.failure import Failure
from host_tools.language import _, error_text

BAUD = {"plotter": 57600, "grbl": 115200, "torch": 115200, "pulses": 115200}
_ANSWER_S = 3.0


def link(
    number: Annotated[
        Optional[int], typer.Argument(min=0, max=4, help="The link that may command from now on; 0: the one of --port.")
    ] = None,
    protocol: Annotated[str, typer.Option(help="What the link of --port speaks: plotter, grbl, torch or pulses.")] = ...,
    port: Port = None,
    baud: AnyBaud = None,
):
    """Hand the command over the machine to another link of the board, or take it.

    Links are numbered from 1 in the order of the board file. Any link may ask, for itself or for another, also for one whose
    language has no word for it. The machine must stand still. Without a number, a grbl link says who commands.

    Examples:

        passo link 0 --protocol grbl --port /dev/ttyACM0        # this one commands
        passo link 2 --protocol plotter --port /dev/ttyUSB0     # the second link of the board file commands
        passo link --protocol grbl
    """
    from host_tools.cli import ports

    if protocol not in BAUD:
        raise Failure("--protocol {}: it has no word for that; ask on a link that speaks {}", protocol, ", ".join(BAUD))
    port = port or ports.only_port()
    baud = baud or BAUD[protocol]
    if protocol == "grbl":
        print(_hand_over_grbl(port, baud, number))
    elif number is None:
        raise Failure("{} has no word for who commands; give the number of a link", protocol)
    else:
        {"plotter": _hand_over_plotter, "torch": _hand_over_torch, "pulses": _hand_over_pulses}[protocol](port, baud, number)
        print(_("link {} commands", number) if number else _("this link commands"))


def _hand_over_grbl(port, baud, number):
    """Give the command to link `number`, if not None; return a line that names the link in command. Raises Failure."""
    from host_tools.clients.grbl import GrblClient

    with GrblClient(port, baud) as client:
        if number is not None:
            client.command(f"$LINK={number}")
        told = [line for line in client.command("$LINK") if line.startswith("[LINK:")]
    if not told:
        raise Failure("{} does not say who commands", port)
    commander, name = told[0][6:-1].split(",", 1)
    return _("link {}, {}, commands", commander, name)


def _hand_over_plotter(port, baud, number):
    """Give the command to link `number`. Raises Failure if the board refuses."""
    from host_tools.clients.plotter import PlotterClient

    with PlotterClient(port, baud) as client:
        client.hand_over(number)


def _hand_over_torch(port, baud, number):
    """Give the command to link `number`. Raises Failure if the board refuses."""
    from host_tools.clients.torch import TorchClient
    from passo.protocols.torch import protocol as torch

    with TorchClient(port, baud) as client:
        client.order(torch.passo(torch.LINK_OF, number))


def _hand_over_pulses(port, baud, number):
    """Give the command to link `number`. Raises Failure if the board refuses, LinkError without an answer within 3 s."""
    from host_tools.clients.serial_port import LinkError
    from host_tools.clients.serial_port import open_port
    from passo.protocols.pulses import protocol as pulses

    line = open_port(port, baud)
    try:
        line.timeout = _ANSWER_S
        line.write(pulses.frame("link", number))
        answer = line.readline().decode("ascii", "replace").strip()
    finally:
        line.close()
    if answer.startswith("error:"):
        number = int(answer[6:].split()[0])
        raise Failure("refused: error {}, {}", number, error_text(number))
    if answer != "ok":
        raise LinkError("{}: no answer, or not one of pulses: {!r}", port, answer)
