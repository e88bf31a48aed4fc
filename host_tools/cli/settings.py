"""`passo settings`: shows a board's settings, changes them, saves them to a file and restores them.

The first line of a back-up is its version. A back-up without one that has Passo's own settings comes from the first firmware;
its masks ($2 to $6 and $23) said what differs from the board file. A back-up with neither comes from grbl, whose masks mean
the same as Passo's since version 2.
"""

import re
from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools.cli.options import AnyBaud, Port
from host_tools.clients.grbl import Refused
from host_tools.failure import Failure, reason
from host_tools.language import _, count_text

VERSION = 2
_HEADER = "; passo settings, version "
_OWN = ("$140=", "$141=")  # Passo's, not grbl's
_ACTIONS = ("show", "backup", "restore")
_STEPS = 100  # steps/mm of x; those of other axes follow
_HOMING_DIRECTION = 23
_MOST_AXES = 4
_KEPT_OFFSETS = ("G54", "G55", "G56", "G57", "G58", "G59")


def settings(
    what: Annotated[Optional[list[str]], typer.Argument(metavar="WHAT", help="show, backup FILE, restore FILE, NAME, or NAME=VALUE …")] = None,
    port: Port = None,
    baud: AnyBaud = None,
    protocol: Annotated[Optional[str], typer.Option(help="Language of the link of --port: grbl, torch, pulses, plotter or keys. Default: found by asking.")] = None,
):  # fmt: skip
    """Show a board's settings with names, units and bounds, change them, save them to a file, or restore them.

    Every language's board has them, and keeps them without power. NAME is a name or a number: x_steps_mm, 100, '$100'; NAME= takes the board
    file's value again. A setting changes only while the machine stands, the tool off. New steps/mm make the position unknown: home again.

    A back-up holds the $ settings, and of a grbl link the work offsets, the tool table and the start-up lines, as they are sent. The output of
    grbl's $$ can be restored as well; back-ups of older firmware are converted.

    Examples:

        passo settings
        passo settings x_steps_mm=49.218 --port /dev/ttyUSB0
        passo settings x_steps_mm --protocol keys --port /dev/ttyUSB0
        passo settings backup router.txt --port /dev/ttyACM0
        passo settings restore router.txt
    """
    what = what or ["show"]
    action, *rest = what
    if action not in _ACTIONS:
        _change_settings(what, port, baud, protocol)
        return
    if action == "show" and rest or action != "show" and len(rest) != 1:
        raise Failure("passo settings {} FILE: the file is missing", action) if not rest else Failure("one file, not {}", " ".join(rest))
    file = Path(rest[0]) if rest else None
    wanted, version = read(file) if action == "restore" else ([], VERSION)
    with board_at(port, baud, protocol) as board:
        if action == "restore":
            changed = restore_lines(board, convert_backup(board, wanted, version) if board.of_lines else wanted)
            print(_("{} of {} were different and are restored", len(changed), count_text(len(wanted), "line")))
            return
        lines = backup_lines(board)
        if action == "backup" and (not board.of_lines or read_masks(board) is not None):
            lines.insert(0, f"{_HEADER}{VERSION}")
    if action == "show":
        from host_tools.clients.setting_names import describe_lines

        print("\n".join(describe_lines(lines)))
        return
    try:
        file.write_text("\n".join(lines) + "\n", encoding="ascii")
    except OSError as error:
        raise Failure("cannot write {}: {}", file, reason(error)) from error
    print(f"{file}: {count_text(len(lines), 'line')}")


def board_at(port, baud, protocol):
    """Return the settings of the board at a port. Its language is found by asking; a board that does not say is a grbl controller's.
    Raises Failure."""
    from host_tools.cli import ports
    from host_tools.cli.log import find_language
    from host_tools.clients import settings as clients

    if protocol not in (None, *clients.BAUD):
        raise Failure("--protocol {}: known are {}", protocol, ", ".join(clients.BAUD))
    port = port or ports.only_port()
    language = protocol or find_language(port, baud or clients.BAUD["grbl"], clients.BAUD)
    return clients.open_settings(language or "grbl", port, baud)


def _change_settings(words, port, baud, protocol):
    """Print and set single settings, `NAME` and `NAME=VALUE`. Checks all names and values before it sends the first. Raises Failure."""
    from host_tools.clients.setting_names import describe_lines
    from host_tools.clients.settings import number_of, value_of

    asked = [(number_of(name), equals, value_of(name, value)) for name, equals, value in (word.partition("=") for word in words)]
    lost = False
    try:
        with board_at(port, baud, protocol) as board:
            for number, equals, value in asked:
                before = board.get(number)
                after = board.set(number, value) if equals else before
                lost = lost or (number // 10 == _STEPS // 10 or number == _HOMING_DIRECTION) and float(after) != float(before)
                print(describe_lines([f"${number}={after}"], _MOST_AXES)[0] + (_("   (before: {})", before) if equals else ""))
    finally:
        if lost:  # also if the board has refused a later one
            print(_("the position is unknown now: home the machine, or set its origin, before it works"))


def backup_lines(client):
    """Return all that a controller keeps, as the lines that restore it: $ settings, start-up lines, work offsets, tool lengths."""
    lines = [line for line in client.command("$$") if line.startswith("$")]
    lines += [line for line in client.command("$N") if line.startswith("$N")]
    for line in client.command("$#"):
        name, colon, places = line.strip("[]").partition(":")
        if name in _KEPT_OFFSETS:
            words = "".join(axis + value for axis, value in zip("XYZA", places.split(",")))
            lines.append(f"G10L2P{_KEPT_OFFSETS.index(name) + 1}{words}")
        elif re.fullmatch(r"T\d+", name):
            lines.append(f"G10L1P{name[1:]}Z{places}")
    return lines


def read_masks(client):
    """Return {number: board file's value} of the settings that are masks; None if the firmware cannot tell."""
    try:
        said = client.command("$MASKS")
    except Refused:
        return None
    for line in said:
        if line.startswith("[MASKS:"):
            pairs = [item.split("=") for item in line[7:].rstrip("]").split(",")]
            return {int(number): int(value) for number, value in pairs}
    return None


def convert_backup(client, wanted, version):
    """Return the lines of a back-up of `version`, converted for this controller. Raises Failure if it would misread a mask."""
    board = read_masks(client)
    if board is None:
        if version >= VERSION and any(_parse_mask(line) for line in wanted) and _is_passo(client.command("$$")):
            raise Failure("the board's firmware is older than this back-up, and reads its masks otherwise: flash it anew first")
        return wanted
    if version >= VERSION:
        return wanted
    lines = [line for line in wanted if line != "$1=255"]  # the first firmware did not release drivers by it
    for index, line in enumerate(lines):
        number, value = _parse_mask(line) or (None, None)
        if number in board:
            lines[index] = f"${number}={value ^ board[number]}"
    return lines


def _parse_mask(line):
    """Return (number, value) of a line that sets a mask, else None."""
    match = re.fullmatch(r"\$(2|3|4|5|6|23)=(\d+)", line)
    return (int(match[1]), int(match[2])) if match else None


def _is_passo(lines):
    """True if a line sets one of Passo's own settings."""
    return any(line.startswith(_OWN) for line in lines)


def read(file):
    """Return (lines, version) of a back-up. Raises Failure if the file is none."""
    try:
        lines = file.read_text(encoding="ascii").splitlines()
    except (OSError, UnicodeError) as error:
        raise Failure("cannot read {}: {}", file, reason(error)) from error
    version = None
    for number, line in enumerate(lines, 1):
        if line.startswith(_HEADER) and line[len(_HEADER) :].isdigit():
            version = int(line[len(_HEADER) :])
            if version > VERSION:
                raise Failure("{} is of a later passo: version {}; this one knows {}", file, version, VERSION)
            lines[number - 1] = ""
        elif line and not re.match(r"\$(\d+|N\d|I)=|G10L[12]P", line):  # $H, $J=… and $X would move, or unlock
            raise Failure("{}, line {}: {!r} is no setting", file, number, line)
    lines = [line for line in lines if line]
    if not lines:
        raise Failure("{} has no settings", file)
    return lines, version or (1 if _is_passo(lines) else VERSION)


def restore_lines(client, wanted):
    """Send the lines that differ from the controller's; return them. Offsets are read in the units of $13. Refused lines are sent again after the
    others, as long as that helps: a setting may depend on another. Raises Refused."""
    have = set(backup_lines(client))
    changed = sorted([line for line in wanted if line not in have], key=_sort_key)
    if any(line.startswith(("G10", "$N")) for line in changed):
        client.command("$X")
        inches = "$13=1" in have
        client.command("G20" if inches else "G21")
    left = changed
    while left:
        refusals = _send_lines(client, left)
        if len(refusals) == len(left):
            raise refusals[left[0]]
        left = list(refusals)
    return changed


def _send_lines(client, lines):
    """Send lines; return {line: Refused} of the refused ones."""
    refusals = {}
    for line in lines:
        try:
            client.command(line)
        except Refused as refusal:
            refusals[line] = refusal
    return refusals


def _sort_key(line):
    """Return a key that sorts offsets before the units of the report, $13, which change how they read."""
    return line.startswith("$13="), line
