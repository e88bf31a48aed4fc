"""`passo emulate`: the firmware as it is flashed, on an emulated Pico, with a machine wired to its pins."""

import signal
import sys
import time
from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools.cli.board import BounceMs, Faults, Seed, StartPlace, TraceFile, VcdFile, _parse_pairs, _parse_positions, _print_errors
from host_tools.failure import Failure, reason
from host_tools.language import _

SLICE_US = 2000  # how long the emulated Pico runs before its lines are served again
LAG_S = 0.1  # if it lags behind the wall clock by more, it does not catch up
IDLE_MS = 20
FLUSH_S = 0.5
UP_LIMIT_MS = 10_000  # emulated; the largest firmware is up after 4 s


def emulate(
    board: Annotated[
        str, typer.Option(help="Board file of a Pico: a name of boards/, or the path of a .py file.")
    ] = "plotter_2014",
    uart0: Annotated[Optional[Path], typer.Option(metavar="PATH", help="A symlink to the pty of UART0.")] = None,
    uart1: Annotated[Optional[Path], typer.Option(metavar="PATH", help="A symlink to the pty of UART1.")] = None,
    tcp: Annotated[
        Optional[int], typer.Option(min=0, max=65535, help="Serve the USB serial port on TCP. 0: any free port.")
    ] = None,
    blank: Annotated[bool, typer.Option("--blank", help="A Pico without files, to be flashed over --tcp.")] = False,
    trace: TraceFile = None,
    vcd: VcdFile = None,
    start: StartPlace = None,
    bounce_ms: BounceMs = 0,
    fault: Faults = None,
    seed: Seed = 0,
):
    """Run the firmware on an emulated Pico, and a machine with it.

    Prints the ports to open: `usb: URL` for the USB serial port, once it is there, and `port: PATH` for UART0 (the first
    link), once the firmware listens. With a C compiler (cc) it is about as fast as a Pico; without one a busy Pico is emulated
    about 25 times slower, and a start takes up to a minute. SIGUSR1 presses the reset button. Ends on SIGTERM or Ctrl-C.

    It runs MicroPython's own UF2 for the Pico: the file that PASSO_UF2 names, the newest in ~/.cache/passo/, or the
    release that it fetches from micropython.org.

    Examples:

        passo emulate --uart0 /tmp/plotter --trace job.csv
        passo emulate --blank --tcp 5001, then: make flash BOARD=plotter_2014 PORT=socket://localhost:5001
    """
    from host_tools import boards
    from host_tools.emulator.binary import find_uf2, load_emulator

    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: sys.exit(0))  # exit at once: the emulated machine does not run yet
    load_emulator()
    uf2 = find_uf2()
    boards.load(board)
    options = {
        "start": _parse_positions(start),
        "bounce_ms": bounce_ms,
        "faults": _parse_pairs("--fault", fault, None),
        "seed": seed,
    }
    if not blank:
        print_progress(_("building the firmware of {}", board))
    machine = _create_machine(board, {} if blank else None, trace, vcd, uf2, options)
    try:
        serve_emulated(machine, {0: uart0, 1: uart1}, tcp, blank)
    finally:
        machine.close()
    _print_errors(machine.plant)


def _create_machine(board, files, trace, vcd, uf2, options):
    """Return an EmulatedMachine of these arguments. Raises Failure for a wrong board file or start."""
    from host_tools.emulator.machine import EmulatedMachine
    from passo.config.boardfile import BoardError

    try:
        return EmulatedMachine(board, files, trace, vcd, uf2, **options)
    except (BoardError, ValueError) as error:
        raise Failure("board {}: {}", board, reason(error)) from error
    except OSError as error:
        raise Failure("cannot write {}: {}", error.filename, reason(error)) from error


def print_progress(text):
    """Print a line on stderr for a user who waits."""
    print(text, file=sys.stderr, flush=True)


def serve_emulated(machine, symlinks, tcp, blank=False):
    """Run until SIGTERM or SIGINT, with a pty for each UART that a link uses and a socket for USB (`tcp`: its port, or None). `symlinks`: {UART's
    number: path or None}. Raises Failure."""
    from host_tools.sim.serial_line import PtyLine, TcpLine

    stopped = []
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: stopped.append(True))
    pressed = []
    signal.signal(signal.SIGUSR1, lambda *_: pressed.append(True))
    ptys, usb = {}, None
    try:
        for name in machine.uart_links():
            ptys[name] = PtyLine(symlinks[machine.uart_number(name)])
        if tcp is not None:
            usb = TcpLine(tcp)
        if not ptys and usb is None:
            raise Failure("all links of this board are on USB: give --tcp to open it")
        if not blank:
            print_progress(_("the Pico starts: it loads the firmware for some two seconds of its own time, up to a minute of yours"))
        machine.boot(lambda: stopped)
        if usb is not None and not stopped:
            print(f"usb: {usb.name}", flush=True)
        _run_until_stopped(machine, ptys, usb, stopped, pressed, blank)
    except TimeoutError as error:
        raise Failure("the Pico does not start: {}", error) from error
    finally:
        for line in [*ptys.values(), *([usb] if usb else [])]:
            line.close()


def _print_ports(machine, ptys, blank):
    """Print the ports of the UARTs once the firmware listens, or has failed to start within 10 s of its own time. Return True then."""
    if not blank and not machine.is_listening():
        if machine.now_ms() < UP_LIMIT_MS:
            return False
        said = machine.pico.console.text.decode("utf-8", "replace").strip()
        print_progress(_("the firmware has not come up: its console says\n{}", said) if said else _("the firmware has not come up"))
    for index, (name, line) in enumerate(ptys.items()):
        print(f"port: {line.name}" if index == 0 else f"port {name}: {line.name}", flush=True)
    return True


def _run_until_stopped(machine, ptys, usb, stopped, pressed, blank):
    """Run the emulated Pico until `stopped` has an item, no faster than the wall clock, SLICE_US at a time; carry bytes between its lines and the
    PC's."""
    from host_tools.sim.serial_line import wait_for_bytes

    lines = [*ptys.values(), *([usb] if usb else [])]
    zero = time.monotonic() - machine.now_ms() / 1000  # wall time at emulated time 0
    flush_at = 0
    announced = False
    while not stopped:
        announced = announced or _print_ports(machine, ptys, blank)
        if pressed:
            pressed.clear()
            machine.pico.press_reset()
        for name, line in ptys.items():
            data = line.read()
            if data:
                machine.send(data, name)
        if usb is not None and machine.pico.usb.up:  # before, a real Pico has no port either
            machine.pico.usb.write(usb.read())
        machine.pico.run(SLICE_US)
        for name, line in ptys.items():
            if machine.replies_so_far(name):
                line.write(machine.take(name))
        said = machine.pico.console.take_output() if announced or usb is not None else b""  # before, `_print_ports` needs it
        if usb is not None and said:
            usb.write(said)
        now = time.monotonic()
        if now >= flush_at:
            machine.flush()
            flush_at = now + FLUSH_S
        ahead = zero + machine.now_ms() / 1000 - now
        if ahead > 0:
            wait_for_bytes(lines, min(IDLE_MS, ahead * 1000))
        elif ahead < -LAG_S:
            zero = now - machine.now_ms() / 1000
