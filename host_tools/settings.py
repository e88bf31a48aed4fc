"""`passo settings`: a controller's settings to a file and back."""

from pathlib import Path
from typing import Optional

import typer

from host_tools.failure import Failure
from host_tools.grbl_client import Refused

_KEPT_OFFSETS = ("G54", "G55", "G56", "G57", "G58", "G59")


def settings(
    action: str = typer.Argument("show", help="show, backup or restore."),
    file: Optional[Path] = typer.Argument(None, help="The file of backup and restore."),
    port: Optional[str] = typer.Option(None, help="Serial port, pty or pyserial URL (socket://host:port)."),
    baud: int = typer.Option(115200, help="Bits per second of a serial port."),
):
    """Show a controller's settings, save them to a file, or bring them back.

    A back-up holds the $ settings, the work offsets and the start-up lines, one a line, as they are sent.

    Examples:

        passo settings

        passo settings backup router.txt --port /dev/ttyACM0

        passo settings restore router.txt
    """
    from host_tools import ports
    from host_tools.grbl_client import GrblClient

    if action not in ("show", "backup", "restore"):
        raise Failure(f"show, backup or restore, not {action!r}")
    if action != "show" and file is None:
        raise Failure(f"passo settings {action} FILE: the file is missing")
    wanted = read(file) if action == "restore" else []
    with GrblClient(port or ports.only(), baud) as client:
        if action == "restore":
            changed = restore(client, wanted)
            print(f"{len(changed)} of {len(wanted)} lines were different and are restored")
            return
        lines = backup(client)
    if action == "show":
        print("\n".join(lines))
        return
    try:
        file.write_text("\n".join(lines) + "\n", encoding="ascii")
    except OSError as error:
        raise Failure(f"cannot write {file}: {error.strerror}") from error
    print(f"{file}: {len(lines)} lines")


def backup(client):
    """All that a controller keeps, as the lines that bring it back."""
    lines = [line for line in client.command("$$") if line.startswith("$")]
    lines += [line for line in client.command("$N") if line.startswith("$N")]
    for line in client.command("$#"):
        name, _, places = line.strip("[]").partition(":")
        if name in _KEPT_OFFSETS:
            words = "".join(axis + value for axis, value in zip("XYZA", places.split(",")))
            lines.append(f"G10L2P{_KEPT_OFFSETS.index(name) + 1}{words}")
    return lines


def read(file):
    """The lines of a back-up. Raises Failure where one is none."""
    try:
        lines = file.read_text(encoding="ascii").splitlines()
    except (OSError, UnicodeError) as error:
        raise Failure(f"cannot read {file}: {error}") from error
    for number, line in enumerate(lines, 1):
        if line and not line.startswith(("$", "G10L2P")):
            raise Failure(f"{file}, line {number}: {line!r} is no setting")
    lines = [line for line in lines if line]
    if not lines:
        raise Failure(f"{file} has no settings")
    return lines


def restore(client, wanted):
    """Send what differs from what the controller has; the lines that did. Offsets are read in the units of $13. What is
    refused is sent again behind the others, as long as that helps: a setting may have to wait for another."""
    have = set(backup(client))
    changed = sorted([line for line in wanted if line not in have], key=_order)
    if any(line.startswith(("G10", "$N")) for line in changed):
        client.command("$X")
        inches = "$13=1" in have
        client.command("G20" if inches else "G21")
    left = changed
    while left:
        refusals = _send(client, left)
        if len(refusals) == len(left):
            raise refusals[left[0]]
        left = list(refusals)
    return changed


def _send(client, lines):
    """{line: Refused} of those that were."""
    refusals = {}
    for line in lines:
        try:
            client.command(line)
        except Refused as refusal:
            refusals[line] = refusal
    return refusals


def _order(line):
    """Offsets before the units of the report, which change how they read."""
    return line.startswith("$13="), line
