"""`passo panel`: one page for the machine, in a browser of this PC or of a phone."""

import asyncio
import atexit
import json
import shutil
from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools.failure import Failure
from host_tools.language import _

_SHARE = Path.home() / ".local" / "share" / "passo"
_JOBS = _SHARE / "jobs"
_OWN = _SHARE / "boards"
_DEMO = "router_3axis"
_WEBSOCKET = "ws:"
_BAUD = 115200  # a link is asked at it what it speaks


def panel(
    demo: Annotated[bool, typer.Option("--demo", help="A virtual machine: no hardware is needed.")] = False,
    port: Annotated[Optional[str], typer.Option(help="Serial port, pty or pyserial URL of the board (socket://host:port).")] = None,
    baud: Annotated[Optional[int], typer.Option(help="Bits per second of a serial port.")] = None,
    protocol: Annotated[
        Optional[str], typer.Option(help="Language of the link of --port: grbl, pulses, torch, plotter or keys. Default: grbl, pulses and torch are found by asking.")
    ] = None,
    board: Annotated[
        Optional[str], typer.Option(help="Board file: the demo's machine; of a board on --port, what its language does not tell (steps/mm).")
    ] = None,
    host: Annotated[str, typer.Option(help="Address to serve; 0.0.0.0: also phones in this network.")] = "127.0.0.1",
    http: Annotated[int, typer.Option(min=0, max=65535, help="Port of the page; 0: any free one.")] = 8080,
    own: Annotated[Path, typer.Option("--boards", help="Folder of your own board files, which a board on --port may become.")] = _OWN,
    prompt: Annotated[Optional[str], typer.Option(help="Port of MicroPython's prompt, to choose a machine; default: --port.")] = None,
    jobs: Annotated[Path, typer.Option(help="Folder of the jobs.")] = _JOBS,
    guest: Annotated[
        Optional[str], typer.Option(metavar="PATH|TCP|ws:PORT", help="A pty (a symlink to it), a TCP port or a WebSocket for a sender beside the page.")
    ] = None,
    trace: Annotated[Optional[Path], typer.Option(metavar="FILE.csv", help="The demo writes where the machine is.")] = None,
    open_: Annotated[bool, typer.Option("--open/--no-open", help="Open the page in this PC's browser.")] = False,
):
    """Show the machine as a page: position, jog, zero, jobs, overrides, outputs, settings, alarms.

    It prints the page's address, with the key that whoever moves the machine needs. The key stays in the browser: it is never
    sent. STOP needs none. The port is the panel's alone; a sender can use it by --guest, and takes the command by `$LINK=0` while
    nothing moves (the page hands it over by a button).

    Examples:

        passo panel --demo --open
        passo panel --demo --board lpt_router --open        # pulse files; torch_manipulator, plotter_2014, …
        passo panel --port /dev/ttyACM0 --guest /tmp/machine        # or 5000, or ws:8081
        passo panel --port /dev/ttyACM0 --host 0.0.0.0      # for a phone; give it the key that is shown
        passo panel --port /dev/ttyUSB0 --prompt /dev/ttyACM0 --board plotter_2014      # it may also become another machine
    """
    from host_tools.panel.board import Demo

    if demo and port:
        raise Failure("give --demo or --port, not both")
    if trace and not demo:
        raise Failure("--trace is for --demo")
    line = _guest_line(guest) if guest else None
    board = board or (_DEMO if demo else None)
    virtual = Demo(board, ["--trace", str(trace)] if trace else []) if demo else None
    try:
        served = _create_panel(virtual, port, baud, protocol, board, line, jobs, host, own, prompt)
        asyncio.run(served.run(host, http, lambda number: _print_address(host, number, served.key, line, open_)))
    finally:
        if virtual:
            virtual.close()
        if line:
            line.close()


def _print_address(host, number, key, line, open_):
    """Print the page's address and key, and open it in a browser if `open_`."""
    from host_tools.sim.consent import print_port
    from host_tools.clients.page_key import in_groups

    address = f"http://{'127.0.0.1' if host == '0.0.0.0' else host}:{number}/"
    print(f"page: {address}#key={key}")
    print(f"key: {in_groups(key)}")
    if line:
        print_port(line)
    print(_("Ctrl-C ends it."), flush=True)
    if open_:
        _open_browser(f"{address}#key={key}")


def _open_browser(address):
    """Open an address in this PC's browser. Its key must not appear in the list of processes, where all users see a browser's arguments: the browser
    gets a file that only this user can read, which leads there."""
    import tempfile
    import webbrowser

    page = Path(tempfile.mkdtemp(prefix="passo-")) / "page.html"  # a folder of this user's only
    page.write_text(f'<!doctype html><title>Passo</title><script>location.replace({json.dumps(address)})</script>')
    atexit.register(shutil.rmtree, page.parent, ignore_errors=True)
    webbrowser.open(page.as_uri())


def _create_panel(virtual, port, baud, protocol, board, line, jobs, host, own, prompt):
    """Return the Panel of a virtual board, or of the board on `port`; None: the only board that is connected. Raises Failure."""
    from host_tools import boards
    from host_tools.cli import ports
    from host_tools.panel import languages
    from host_tools.panel.board import Port
    from host_tools.panel.panel import Panel

    name = virtual.name if virtual else port or ports.only_port()
    language = _find_language(_language_of(boards.load(board)) if virtual else protocol, name, baud, line)
    machines, change, files = _demo_machines(virtual, own, line) if virtual else _cable_machines(name, prompt, board, own, line)
    table = boards.load(board or languages.BOARDS[language])
    return Panel(
        lambda changed: Port(name, baud or languages.BAUD[language], changed), jobs, line, host, language, table, machines, change,
        lambda: ["--emulated", virtual.board] if virtual else ["--port", prompt or name], (own, files),
    )  # fmt: skip


def _languages_for(guest):
    """Return the languages of machines to choose from: beside a sender grbl alone."""
    from host_tools.panel import languages

    return ("grbl",) if guest else tuple(languages.BOARDS)


def _demo_machines(virtual, own, guest):
    """Return (names of the virtual machines to choose from, function that starts one, {name: board file})."""
    from host_tools import boards

    files = _machines_speaking(boards, virtual.board, own, _languages_for(guest))

    def change_demo(name):
        """Start the virtual machine `name`; return (its port, its first link, its board file's table). Raises Failure."""
        table = boards.load(files[name])
        return virtual.change_board(files[name]), table["links"][0], table

    return list(files), change_demo, files


def _cable_machines(port, prompt, board, own, guest):
    """Return (names of the machines that the board on `port` may become, function that makes it one, {name: board file}); print the files
    left out."""
    from host_tools.cli.machine import become_machine
    from host_tools.panel.cable import Cable

    cable = Cable(port, prompt or port, board or "", own, _languages_for(guest), become_machine)
    for what in cable.wrong:
        print(_("left out: {}", what))
    return cable.machine_names(), cable.change_machine, cable.files


def _guest_line(guest):
    """Return the line of --guest for a sender: a pty, a TCP port or a WebSocket. Raises Failure if it is taken."""
    from host_tools.sim.consent import Consent, GuestLine
    from host_tools.sim.serial_line import TAKEN, PtyLine, TcpLine
    from host_tools.sim.websocket_line import WebSocketLine

    if guest.startswith(_WEBSOCKET) and guest[len(_WEBSOCKET) :].isdigit():
        return GuestLine(WebSocketLine(int(guest[len(_WEBSOCKET) :])), Consent())
    return GuestLine(TcpLine(int(guest), message=TAKEN["grbl"]), Consent()) if guest.isdigit() else PtyLine(guest)


def _find_language(language, port, baud, guest):
    """Return the language of a board: as given, or else found by asking. Raises Failure if the panel does not speak it."""
    from host_tools.cli.log import find_language
    from host_tools.panel import languages

    if not language:
        language = find_language(port, baud or _BAUD)
        if language == "torch":
            _check_torch(port, baud)
    if language not in languages.BOARDS:
        raise Failure("{}: the panel speaks {}", language, ", ".join(languages.BOARDS))
    if guest and language != "grbl":
        raise Failure("--guest is for a board that speaks grbl: a sender beside the page")
    return language


def _check_torch(port, baud):
    """Raise Failure if nothing answers: find_language() takes a board that answers no other language for a torch."""
    from host_tools.clients.torch import TorchClient
    from host_tools.clients.serial_port import LinkError

    try:
        with TorchClient(port, baud or _BAUD, timeout_s=1.0) as client:
            answers = client.status() is not None
    except LinkError:
        answers = False
    if not answers:
        raise Failure(
            "{}: no answer in grbl, pulses or Passo's torch; of a plotter or a kit of keys say --protocol plotter, --protocol keys", port,
        )


def _language_of(board):
    """Return the protocol of the first link of a board file."""
    return board["links"][0]["protocol"]


def _machines_speaking(boards, first, own, speaking):
    """Return {name: board file} of those whose first link speaks one of these languages, `first` at the head; print and leave out wrong files."""
    from host_tools import board_files

    found = {first: first}
    for name, file in board_files.available_files(own).items():
        try:
            if _language_of(boards.load(file)) in speaking:
                found.setdefault(name, file)
        except Failure as failure:
            print(_("left out: {}", failure.message()))
    return found
