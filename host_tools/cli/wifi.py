"""`passo wifi`: name, passphrase and key of a board's network, set over USB."""

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools import interpreter
from host_tools.failure import Failure
from host_tools.language import _

FILE = "wifi.json"  # on the board: passo/web/radio.py reads it
_TIMEOUT_S = 60
_LEAST, _MOST = 8, 63  # characters of a WPA2 passphrase
_NAME_BYTES = 32
_TURN_MS = 100
_WEAK = 12  # characters: a shorter passphrase gets a warning

app = typer.Typer(
    help="""Set up the Wi-Fi of a board whose board file has a network: its radio is off until then.

    The key that proves who may move the machine is made here and stays on the board. Whoever has the USB cable can see it.

    Examples:

        passo wifi access tocha --port /dev/ttyACM0
        passo wifi show --port /dev/ttyACM0
        passo wifi off --port /dev/ttyACM0
    """,
    no_args_is_help=True,
)
Port = Annotated[Optional[str], typer.Option(help="USB serial port of the board (passo ports).")]
Passphrase = Annotated[Optional[str], typer.Option(help="Asked for if it is left out: then it stays out of the shell's history.")]


def _run_mpremote(port, *words):
    """Run mpremote, up to a minute; return its output and exit status. Raises Failure if no board answers."""
    from host_tools.cli.flash import check_port, no_answer_failure

    check_port(port)
    command = [*interpreter.mpremote_command(port), *words]
    try:
        result = subprocess.run(command, capture_output=True, text=True, timeout=_TIMEOUT_S)
    except subprocess.TimeoutExpired:
        raise no_answer_failure(port) from None
    if result.returncode and "Traceback" not in result.stderr and "No such file" not in result.stderr:
        raise no_answer_failure(port)
    return result.stdout, result.returncode


def _port_or_only(port):
    """Return the port given, or that of the only board. Raises Failure."""
    from host_tools.cli import ports

    return port or ports.only_port()


def _read_network(port):
    """Return the board's network file, parsed; None if it has none, or a damaged one."""
    text, status = _run_mpremote(port, "cat", ":" + FILE)
    if status:
        return None
    try:
        return json.loads(text)
    except ValueError:
        return None


def _key_of(found):
    """Return the key in a network file of _read_network(); "" if it has none, or a wrong one."""
    from host_tools.clients import page_key

    try:
        return page_key.read_key(found["key"])
    except (KeyError, TypeError, AttributeError, ValueError):
        return ""


def check_network(name, passphrase):
    """Raise Failure if a radio cannot take this name and passphrase, or the passphrase is guessed at once."""
    if not 1 <= len(name.encode()) <= _NAME_BYTES:
        raise Failure("a network's name has 1 to {} bytes, not {}", _NAME_BYTES, len(name.encode()))
    if not _LEAST <= len(passphrase) <= _MOST or not all(" " <= letter <= "~" for letter in passphrase):
        raise Failure("a WPA2 passphrase has {} to {} letters, digits or signs, without accents", _LEAST, _MOST)
    if len(set(passphrase)) < 4 or name in passphrase:
        raise Failure("this passphrase is guessed at once: take another")


def _write_network(mode, name, passphrase, port, new_key):
    """Ask for the passphrase if it is None, write the network file to the board, reset it, and print its key. `mode`: access or station. Raises
    Failure."""
    import os

    from host_tools.clients import page_key

    port = _port_or_only(port)
    if passphrase is None:
        passphrase = typer.prompt(_("passphrase"), hide_input=True, confirmation_prompt=mode == "access" and _("the passphrase again"))
    check_network(name, passphrase)
    before = _read_network(port)
    key = page_key.make_key(os.urandom) if new_key else _key_of(before) or page_key.make_key(os.urandom)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / FILE
        path.touch(mode=0o600)
        path.write_text(json.dumps({"mode": mode, "name": name, "passphrase": passphrase, "key": key}))
        status = _run_mpremote(port, "cp", str(path), ":" + FILE, "+", "reset")[1]
    if status:
        raise Failure("the board on {} did not take the file: try again", port)
    print(_("access point {}; the board starts anew", name) if mode == "access" else _("station of {}; the board starts anew", name))
    print(f"key: {page_key.in_groups(key)}")
    if len(passphrase) < _WEAK:
        print(_("a passphrase of {} characters or more would be harder to guess", _WEAK), file=sys.stderr)


NewKey = Annotated[bool, typer.Option("--new-key", help="Another key: pages that have the old one move nothing any more.")]


@app.command()
def access(
    name: Annotated[str, typer.Argument(help="Name of the board's own network.")],
    passphrase: Passphrase = None, port: Port = None, new_key: NewKey = False,
):  # fmt: skip
    """Make the board an access point of its own, with WPA2: 192.168.4.1.

    Examples:

        passo wifi access tocha --port /dev/ttyACM0
    """
    _write_network("access", name, passphrase, port, new_key)


@app.command()
def station(
    name: Annotated[str, typer.Argument(help="Name of the network it joins.")],
    passphrase: Passphrase = None, port: Port = None, new_key: NewKey = False,
):  # fmt: skip
    """Have the board join a network: http://passo.local/, or as the board file's network.host says.

    Examples:

        passo wifi station workshop --port /dev/ttyACM0
    """
    _write_network("station", name, passphrase, port, new_key)


@app.command()
def show(port: Port = None):
    """Show the network's name, and the key for pages. The passphrase is not shown.

    Examples:

        passo wifi show --port /dev/ttyACM0
    """
    from host_tools.clients import page_key

    found = _read_network(_port_or_only(port))
    if not found:
        print(_("the radio is off"))
        return
    name = found["name"]
    print(_("access point {}", name) if found["mode"] == "access" else _("station of {}", name))
    print(f"key: {page_key.in_groups(_key_of(found))}" if _key_of(found) else _("its key is too short, and the radio stays off: passo wifi {} makes a new one", found["mode"]))


@app.command()
def off(port: Port = None):
    """Forget name, passphrase and key: the radio is off.

    Examples:

        passo wifi off --port /dev/ttyACM0
    """
    port = _port_or_only(port)
    _run_mpremote(port, "rm", ":" + FILE)
    _run_mpremote(port, "reset")
    print(_("the radio is off"))


@app.command()
def bridge(
    host: Annotated[str, typer.Argument(help="The board: passo.local, or its address.")],
    key: Annotated[
        Optional[str],
        typer.Option(
            help="The board's key (passo wifi show). Default: asked for. Other users of this PC see what stands in a command.", envvar="PASSO_KEY"
        ),
    ] = None,
    tcp_port: Annotated[int, typer.Option(help="The board file's network.tcp_port.")] = 23,
    link: Annotated[Optional[str], typer.Option(help="A symlink to the pty for the sender.")] = None,
    tcp: Annotated[Optional[int], typer.Option(min=0, max=65535, help="A TCP socket for the sender, not a pty. 0: any free port.")] = None,
    websocket: Annotated[
        Optional[int], typer.Option(min=0, max=65535, help="A WebSocket for the sender, not a pty. 0: any free port.")
    ] = None,
):
    """Give a grbl sender on this PC the board over its network. Every line is proven by the key, which is never sent.

    Examples:

        passo wifi bridge passo.local --link /tmp/router

        PASSO_KEY=ABCD-EFGH-JKLM-NPQR passo wifi bridge 192.168.4.1 --tcp 5000

        passo wifi bridge passo.local --websocket 8081
    """
    if key is None:
        if not sys.stdin.isatty():
            raise Failure("give the board's key: PASSO_KEY=…")
        key = typer.prompt(_("key"), hide_input=True)
    from host_tools.clients.signed import Bridge
    from host_tools.sim.consent import Consent, GuestLine, print_port
    from host_tools.sim.serial_line import TAKEN, PtyLine, TcpLine
    from host_tools.sim.websocket_line import WebSocketLine
    from host_tools.cli.key_option import key_of

    key = key_of(key, "PASSO_KEY")
    if websocket is not None:
        line = GuestLine(WebSocketLine(websocket), Consent())
    else:
        line = GuestLine(TcpLine(tcp, message=TAKEN["grbl"]), Consent()) if tcp is not None else PtyLine(link)
    try:
        made = Bridge(host, tcp_port, key, line)
        print_port(line)
        try:
            while True:
                made.carry_bytes(_TURN_MS)
                if line.consent:
                    line.consent.poll()
        finally:
            made.close()
    except KeyboardInterrupt:
        pass
    finally:
        line.close()
