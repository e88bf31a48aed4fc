"""`passo log`: a board's event log, what was refused and what stopped the machine, from a link that speaks grbl."""

from typing import Optional

import typer


def log(
    port: Optional[str] = typer.Option(None, help="Serial port, pty or pyserial URL (socket://host:port)."),
    baud: int = typer.Option(115200, help="Bits per second of a serial port."),
):
    """Show the last errors and alarms of all links, and how many of each there were since the start.

    The log is the machine's: a link that speaks grbl shows what another was refused, in a language without a word for no.

    Example: passo log --port /dev/ttyACM0
    """
    from host_tools import ports
    from host_tools.grbl_client import GrblClient

    with GrblClient(port or ports.only(), baud) as client:
        for line in client.command("$LOG"):
            text = shown(line)
            if text:
                print(text)


def shown(line):
    """A line of $LOG as people read it; None for any other."""
    from passo.protocols import errors

    name, _, fields = line.strip("[]").partition(":")
    if name == "LOG":
        ms, number, who = fields.split(",", 2)
        return f"{int(ms) / 1000:12.3f} s  {who:<10} {number:>3}  {errors.text(int(number))}"
    if name == "LOGGED":
        counts = [part.split("x") for part in fields.split(",") if part]
        return "since the start: " + (", ".join(f"{count} times {number}" for count, number in counts) or "nothing")
    return None
