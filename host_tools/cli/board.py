"""`passo board`: the firmware on the virtual port, on serial lines that any program can open."""

import contextlib
import os
import signal
import threading
import time
from pathlib import Path
from typing import Annotated, List, Optional

import typer

from host_tools.failure import Failure, reason
from host_tools.language import _
from host_tools.panel.board import END_WITH_STDIN

_FLASH_BYTES = 64 * 1024  # that --flash has to have room for: settings, the journal's pages, a small job
FLUSH_S = 0.5  # longest time before buffered rows are written

# Options of a machine with a plant, which `passo emulate` has too.
TraceFile = Annotated[Optional[Path], typer.Option(metavar="FILE.csv", help="Write where the machine is, step by step.")]
VcdFile = Annotated[Optional[Path], typer.Option(metavar="FILE.vcd", help="Write the pins, for GTKWave or PulseView.")]
StartPlace = Annotated[
    Optional[str], typer.Option(metavar="X,Y", help="Where the head stands, in steps from the origin (random).")
]
BounceMs = Annotated[int, typer.Option(min=0, max=1000, help="Barriers chatter this long after a change.")]
Faults = Annotated[
    Optional[List[str]], typer.Option(metavar="INPUT=KIND[@MS[-MS]]", help="An input that is dead, stuck, pressed, broken (its wire) or bounces, from MS on, to MS.")
]
Touchable = Annotated[bool, typer.Option("--stock", help="A piece with a hole, a touch plate and a boss lie on the table, and close the probe.")]
Seed = Annotated[int, typer.Option(help="Of all that is random: start and chatter.")]
FlashFolder = Annotated[
    Optional[Path], typer.Option(metavar="FOLDER", help="Keep settings and stored jobs there; otherwise they end with it.")
]

TcpPort = Annotated[Optional[int], typer.Option(min=0, max=65535, help="Serve TCP sockets, not ptys: the first link's at PORT, the next at PORT + 1. 0: any free ports.")]
HttpPort = Annotated[
    Optional[int], typer.Option(min=0, max=65535, help="Serve the board's HTTP on 127.0.0.1, as its Wi-Fi would. 0: any free port.")
]
Idle = Annotated[bool, typer.Option("--idle/--no-idle", help="Keep or leave out the time in which nothing moves.")]
SignedPort = Annotated[
    Optional[int], typer.Option(min=0, max=65535, help="Serve the board's grbl over the network, for passo wifi bridge. 0: any free port.")
]
Key = Annotated[Optional[str], typer.Option(help="The network's key (a new one).")]


def board(
    board: Annotated[str, typer.Option(help="Board file: a name of boards/, or the path of a .py file.")] = "plotter_2014",
    protocol: Annotated[
        Optional[List[str]], typer.Option(metavar="[LINK=]NAME", help="Another protocol for a link (the first).")
    ] = None,
    link: Annotated[
        Optional[List[str]], typer.Option(metavar="[LINK=]PATH", help="A symlink to the pty of a link (the first).")
    ] = None,
    tcp: TcpPort = None,
    http: HttpPort = None,
    signed: SignedPort = None,
    key: Key = None,
    time_: Annotated[str, typer.Option("--time", metavar="real|fast", help="Fast jumps through motion.")] = "real",
    trace: TraceFile = None,
    idle: Idle = True,
    vcd: VcdFile = None,
    start: StartPlace = None,
    bounce_ms: BounceMs = 0,
    fault: Faults = None,
    seed: Seed = 0,
    stock: Touchable = False,
    flash: FlashFolder = None,
):
    """Run the firmware on a virtual board, and a machine with it.

    Prints the port to open: `port: PATH` for the first link, `port NAME: PATH` for the others. Ctrl-C or SIGTERM ends it:
    motors and pen safe, all files written.

    With --no-idle the trace leaves out the time in which nothing moves, so two traces of the same job are equal byte for byte.

    Examples:

        passo board --time fast --trace job.csv
        passo board --link /tmp/plotter --bounce-ms 4 --fault barrier_x=dead
        passo board --board mill_2004 --fault dx2=dead@5000-6000 --fault bxb=pressed@8000
        passo board --board boards/mine.py --tcp 5000 --vcd pins.vcd
        passo board --board torch_pico_w --http 8080
    """
    from host_tools import boards
    from host_tools.switches import print_cautions
    from passo.config.boardfile import BoardError, check

    if time_ not in ("real", "fast"):
        raise Failure("--time is real or fast, not {!r}", time_)
    config = boards.load(board)
    print_cautions(config)
    try:
        check(config)
    except BoardError as error:
        raise Failure("board {}: {}", board, reason(error)) from error
    options = {
        "start": _parse_positions(start), "bounce_ms": bounce_ms, "faults": _parse_pairs("--fault", fault, None), "seed": seed,
        "stock": _create_stock(config) if stock else None,
        "idle": idle,
        "radio": _create_radio(config, {"http": http, "tcp": signed}, key),
        "flash": _check_flash_folder(flash),
    }  # fmt: skip
    names = [entry["name"] for entry in config["links"]]
    serve_board(config, time_, _parse_pairs("--protocol", protocol, names), _parse_pairs("--link", link, names), tcp, trace, vcd, options)


def serve_board(config, mode, protocols, links, tcp, trace, vcd, options):
    """Run a virtual board until SIGTERM or SIGINT. `mode`: real or fast; `protocols`, `links`: {link: language}, {link: symlink to its pty}; `tcp`:
    first port, or None for ptys; `trace`, `vcd`: files or None; `options`: those of sim.machine.Machine. Raises Failure."""
    from host_tools.build.pc_kernels import use_compiled
    from host_tools.sim.machine import Machine
    from host_tools.sim.serial_line import PtyLine, wait_for_bytes
    from passo import errors
    from passo.config.boardfile import BoardError
    from passo.records import NETWORK_PORTS

    if any("accel_mm_s2" in axis for axis in config["axes"]):  # others have little to compute
        use_compiled()
    stopped = []
    for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
        if signal.getsignal(number) != signal.SIG_IGN:  # as nohup has it
            signal.signal(number, lambda *_: stopped.append(True))
    if os.environ.get(END_WITH_STDIN):
        threading.Thread(target=_end_with_stdin, daemon=True).start()
    lines = {}
    try:
        cables = [entry["name"] for entry in config["links"] if not (config.get("network") and entry["port"] in NETWORK_PORTS)]
        for index, name in enumerate(cables):
            lines[name] = PtyLine(links.get(name)) if tcp is None else _tcp_line(tcp, index, name, _protocol_of(config, name, protocols))
        watched = list(lines.values())
        try:
            machine = Machine(
                config,
                lines,
                mode,
                lambda milliseconds: wait_for_bytes(watched, milliseconds),
                protocols,
                trace,
                vcd,
                **options,
            )
        except (BoardError, ValueError) as error:
            raise Failure("{}", reason(error)) from error
        except OSError as error:
            raise Failure("cannot write {}: {}", error.filename, reason(error)) from error
        for name, line in lines.items() if tcp is not None else ():
            line.taken = lambda address, name=name: machine.app.controller.machine.note(errors.LINK_TAKEN, f"{name} {address}")
        # Those of the network; a stored job's line has nothing to wait for.
        watched += [link.serial for link in machine.app.links if link.name not in lines and hasattr(link.serial, "watched")]
        try:
            for index, line in enumerate(lines.values()):
                print(f"port: {line.name}" if index == 0 else f"port {list(lines)[index]}: {line.name}", flush=True)
            _print_network(options["radio"])
            _run_until_stopped(machine, stopped)
        finally:
            machine.close()
        _print_errors(machine.plant)
    finally:
        for line in lines.values():
            line.close()


def _protocol_of(config, name, protocols):
    """Return the language of a link: that of --protocol, else the board file's."""
    return protocols.get(name) or next(entry["protocol"] for entry in config["links"] if entry["name"] == name)


def _tcp_line(port, index, name, protocol):
    """Return the TCP line of link number `index`, at `port` + index; 0: any free port. Raises Failure if the port is taken."""
    from host_tools.sim.serial_line import TAKEN, TcpLine

    try:
        return TcpLine(port and port + index, message=TAKEN.get(protocol, b""))
    except Failure as failure:
        raise Failure("link {}: {}", name, failure) from failure if index else failure


def _end_with_stdin():
    """Send this process SIGTERM once standard input ends: the program that started it has ended."""
    with contextlib.suppress(OSError):
        while os.read(0, 4096):
            pass
    os.kill(os.getpid(), signal.SIGTERM)


def _create_stock(config):
    """Return the Stock of --stock, which closes the probe. Raises Failure if the machine has no probe, or fewer than three axes."""
    from host_tools.sim.stock import Stock

    if not Stock.can_touch(config):
        raise Failure("--stock: the board file {} has no input probe, or less than three axes", config["name"])
    return Stock(config)


def _create_radio(config, ports, key):
    """Return a LoopbackRadio for `ports`, {"http" or "tcp": port or None}; None if no port is asked for. Raises Failure if the board file has no link
    of that kind."""
    from host_tools.cli.key_option import key_of
    from host_tools.sim.radio import LoopbackRadio
    from host_tools.clients import page_key

    wanted = {kind: port for kind, port in ports.items() if port is not None}
    has = [entry["port"] for entry in config["links"]] if config.get("network") else []
    for kind in wanted:
        if not {"http": {"http", "page"}, "tcp": {"tcp"}}[kind] & set(has):
            option = "--http" if kind == "http" else "--signed"
            raise Failure("{}: no link of the board file {} has the port {}, see docs/use/network.md", option, config["name"], kind)
    return LoopbackRadio(wanted, key_of(key, "--key") if key else page_key.make_key(os.urandom), config) if wanted else None


def _print_network(radio):
    """Print the addresses and the key of the board's network, if it has one."""
    if radio is not None:
        from host_tools.clients.page_key import in_groups

        for kind in radio.open_kinds():
            path = f"/#key={radio.key}" if kind == "http" else ""
            print(f"{kind}: {kind}://127.0.0.1:{radio.port_of(kind)}{path}")
        print(f"key: {in_groups(radio.key)}", flush=True)


def _run_until_stopped(machine, stopped):
    """Run a virtual machine until `stopped` has an item; write buffered rows of its files each FLUSH_S."""
    flush_at = 0
    while not stopped:
        machine.cycle()
        now = time.monotonic()
        if now >= flush_at:
            machine.flush()
            flush_at = now + FLUSH_S


def _print_errors(plant):
    """Print on stderr how many steps and signals the machine could not follow, and the first of them with its time in ms."""
    if plant.error_count:
        tick, text = plant.errors[0]
        typer.echo(_("the machine: {} errors; the first at {:.3f} ms: {}", plant.error_count, tick / 12500, text), err=True)


def _parse_pairs(option, texts, names):
    """Return {name: value} of NAME=VALUE texts. With `names`, a text without a name belongs to the first of them. Raises Failure."""
    pairs = {}
    for text in texts or ():
        name, equals, value = text.partition("=")
        if names is None:
            if not equals:
                raise Failure("{} {}: NAME=VALUE is wanted", option, text)
        elif not equals or name not in names:
            if equals and "/" not in name:
                raise Failure("{} {}: there is no link {!r}; known are {}", option, text, name, ", ".join(names))
            name, value = names[0], text
        pairs[name] = value
    return pairs


def _check_flash_folder(path):
    """Return the folder of --flash after a trial write of 64 kB there; None if there is no such option. Raises Failure if it cannot be written."""
    if path is not None:
        tried = path / ".tried"
        try:
            path.mkdir(parents=True, exist_ok=True)
            with open(tried, "wb", buffering=0) as file:
                file.write(bytes(_FLASH_BYTES))
        except OSError as error:
            raise Failure("--flash: cannot write {}: {}", error.filename or tried, reason(error)) from error
        finally:
            with contextlib.suppress(OSError):
                tried.unlink()
    return path


def _parse_positions(text):
    """Return the steps of --start, X,Y…, one number an axis; None: random. Raises Failure."""
    if text is None:
        return None
    try:
        return [int(part) for part in text.split(",")]
    except ValueError:
        raise Failure("--start {}: whole steps are wanted, one number an axis, for example 300,200", text) from None
