"""Options that several verbs have."""

from pathlib import Path
from typing import Annotated, Optional

import typer

Port = Annotated[Optional[str], typer.Option(help="Serial port, pty or pyserial URL (socket://host:port).")]
Baud = Annotated[int, typer.Option(help="Bits per second of a serial port.")]
AnyBaud = Annotated[Optional[int], typer.Option(help="Bits per second of a serial port.")]  # None: the language's
Log = Annotated[Optional[Path], typer.Option(help="Save the bytes on the wire to this file.")]
BoardName = Annotated[str, typer.Option("--board", help="Board file with the steps/mm: a name, or the path of a .py file.")]
Protocol = Annotated[
    Optional[str], typer.Option(help="Language of the link of --port: grbl, torch, pulses or plotter. Default: found by asking.")
]
DropZ = Annotated[bool, typer.Option("--drop-z", help="Leave Z out, for a machine without it. Refused if the tool is on as Z rises.")]
ZPen = Annotated[Optional[float], typer.Option(metavar="MM", help="For a machine without Z: the tool is off while the program's Z is above this.")]
