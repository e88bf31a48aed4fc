"""`passo pulses`: plays files of pulse codes as LPTControl did (forward, backward, repeated); checks and converts them."""

import zlib
from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools.cli.options import Baud, Port
from host_tools.cli.pulses_files import BOARD, BoardName, PulseFile, check, convert, example, image, ramps
from host_tools.failure import Failure
from host_tools.language import _

app = typer.Typer(
    help="""Play files of pulse codes, as LPTControl did, and convert them.

    Examples:

        passo pulses example octagon -o octagon.txt
        passo pulses play octagon.txt --repeat 3 --port /dev/ttyACM0
        passo pulses convert part.gcode -o part.txt
    """,
    no_args_is_help=True,
)
_NUMBERS = {"ignore_unknown_options": True}  # so that -5 is a number

Log = Annotated[Optional[Path], typer.Option(help="Save what is said on the wire to this file.")]
Back = Annotated[bool, typer.Option("--back", help="And then backward.")]
Wait = Annotated[bool, typer.Option("--wait/--no-wait", help="Show position and state until the machine stands.")]


def _connect_client(port, baud, log=None):
    """Return a PulsesClient on the port, or on the only board. Raises Failure."""
    from host_tools.cli import ports
    from host_tools.clients.pulses import PulsesClient

    return PulsesClient(port or ports.only_port(), baud, log)


def _follow_run(client, wait, playing):
    """Show progress until the machine is at rest, and return its status; None without `wait`. Ctrl-C stops it. Raises Failure if it is stopped, in
    alarm, or `playing` and only paused."""
    from host_tools.cli.pulses_panel import Panel, status_text
    from host_tools.clients.pulses import check

    if not wait:
        return
    try:
        with Panel(client) as panel:
            status = panel.follow_run(playing)
    except KeyboardInterrupt:
        client.command("stop")
        raise Failure("stopped by Ctrl-C at {}", status_text(client.status())) from None
    for line in client.said:
        check(line, _("the run"))
    print(status_text(status))
    if status["state"] == "alarm":
        raise Failure("the machine is in alarm")
    if status["state"] == "hold" and playing:
        if status["ask"] == "1":
            raise Failure("paused at command {} of {}: passo pulses speed N goes on", status["at"], status["of"])
        raise Failure("paused at command {} of {}: passo pulses run goes on, stop ends it", status["at"], status["of"])
    return status


def _send_order(words, port, baud, wait=True, playing=False):
    """Send an order of the language, and follow the machine as _follow_run() does. Raises Failure."""
    with _connect_client(port, baud) as client:
        client.command(*words)
        return _follow_run(client, wait, playing)


# --- on a board


@app.command()
def play(
    file: PulseFile,
    repeat: Annotated[int, typer.Option(min=1, max=100, help="How many times.")] = 1,
    speed: Annotated[Optional[int], typer.Option(min=1, help="mm/min to begin with, up to the file's own.")] = None,
    stream: Annotated[bool, typer.Option("--stream", help="Play it as it is sent; for what is too long to store.")] = False,
    begin: Annotated[
        Optional[int], typer.Option("--from", min=0, help="Go to where this command of the file begins, and stream from there.")
    ] = None,
    back: Annotated[bool, typer.Option("--back", help="Stream it backward: from its end, where the head stands, or --from.")] = False,
    port: Port = None, baud: Baud = 115200, wait: Wait = True, log: Log = None,
):  # fmt: skip
    """Send a file and play it. The board checks and stores it first, unless it is streamed.

    Keys while it plays: p pause, r go on, b turn round, s stop (also Ctrl-C); a number and Enter set a new speed in mm/min, also
    the one that a +0 in the file waits for. This program keeps the port until the end. With --no-wait it ends as soon as the
    file is on the board; then the other commands of passo pulses control the run. Exit status 1 if the run was stopped, or if
    it paused and there is no keyboard to go on with.

    Examples:

        passo pulses play square.txt
        passo pulses play hexagon.txt --repeat 100 --speed 800 --no-wait
        passo pulses play engraving.txt --stream --repeat 3
        passo pulses play engraving.txt --from 250000 --back
    """
    from host_tools.programs import pulse_file

    if stream or back or begin is not None:
        _stream_file(file, repeat, speed, begin, back, port, baud, wait, log)
        return
    data = pulse_file.load_pulses(file)
    from host_tools.cli.pulses_panel import Panel

    from host_tools.cli.pulses_stream import tell_journal
    from host_tools.programs.long_pulses import codes_of

    with _connect_client(port, baud, log) as client:
        tell_journal(client, f"$JR={zlib.crc32(codes_of(data)) or 1:08x}")
        try:
            with Panel(client):
                count = client.send_file(data)
        except KeyboardInterrupt:
            client.command("stop")
            raise Failure("stopped by Ctrl-C") from None
        print(_("{}: {} commands", file, count))
        if speed:
            client.command("speed", speed)
        client.command("run", repeat)
        _follow_run(client, wait, playing=True)


def _stream_file(file, repeat, speed, begin, back, port, baud, wait, log):
    """Play a file of any length while it is sent, from command `begin` if not None. Raises Failure."""
    from host_tools.cli.pulses_stream import jog_to, play_long
    from host_tools.programs.long_pulses import LongFile

    if not wait:
        raise Failure("to stream a file takes as long as it plays; leave out --no-wait")
    if back and repeat > 1:
        raise Failure("backward a file is played once: it ends at its start")
    with _connect_client(port, baud, log) as client:
        axes = "xyz"[: len(client.status()["place"].split(","))]
        source = LongFile(file, axes)
        number = source.total if back and begin is None else begin or 0
        source.seek(number)
        print(_("{}: {} commands", file, source.total))
        try:
            if begin is not None:
                jog_to(client, source, number)
            play_long(client, source, number, back, repeat, speed)
        except KeyboardInterrupt:
            client.command("stop")
            raise Failure("stopped by Ctrl-C") from None
        _follow_run(client, wait, playing=True)


@app.command()
def run(
    times: Annotated[Optional[int], typer.Argument(min=1, max=100, help="How many times.")] = None,
    port: Port = None, baud: Baud = 115200, wait: Wait = True,
):  # fmt: skip
    """Play the stored file, or go on after a pause.

    Example: passo pulses run 5
    """
    _send_order(("run", times) if times else ("run",), port, baud, wait, playing=True)


@app.command()
def reverse(port: Port = None, baud: Baud = 115200, wait: Wait = True):
    """Play backward from here to the start of the file; `run` goes forward again.

    The board remembers only the last commands of a streamed file. Exit status 1 if it had to stop before the start.

    Example: passo pulses reverse
    """
    status = _send_order(("back",), port, baud, wait, playing=True)
    if status and status["state"] == "idle" and int(status["at"]):
        raise Failure(
            "not back at the start, but at command {} of {}: what was streamed before is forgotten; passo pulses run goes forward again",
            status["at"], status["of"],
        )


@app.command()
def pause(port: Port = None, baud: Baud = 115200):
    """Pause at the next step.

    Example: passo pulses pause
    """
    _send_order(("pause",), port, baud)


@app.command()
def stop(port: Port = None, baud: Baud = 115200):
    """Stop at once, tool off, and go back to the start of the file.

    Example: passo pulses stop
    """
    _send_order(("stop",), port, baud)


@app.command()
def step(back: Back = False, port: Port = None, baud: Baud = 115200):
    """Execute one command of the file; --back: the previous one, backward.

    Example: passo pulses step --back
    """
    _send_order(("step", "back") if back else ("step",), port, baud)


@app.command("return")
def return_(back: Back = False, port: Port = None, baud: Baud = 115200, wait: Wait = True):
    """Undo the moves by hand, the same way back, and go on with the file.

    Example: passo pulses return
    """
    _send_order(("return", "back") if back else ("return",), port, baud, wait, playing=True)


@app.command("continue")
def continue_(back: Back = False, port: Port = None, baud: Baud = 115200, wait: Wait = True):
    """Forget the moves by hand and go on with the file from here.

    Example: passo pulses continue
    """
    _send_order(("continue", "back") if back else ("continue",), port, baud, wait, playing=True)


@app.command()
def repeat(times: Annotated[int, typer.Argument(min=1, max=100)], port: Port = None, baud: Baud = 115200):
    """Set how many times the file is played.

    Example: passo pulses repeat 10
    """
    _send_order(("repeat", times), port, baud, wait=False)


@app.command()
def speed(
    mm_min: Annotated[int, typer.Argument(min=1, help="mm/min along the path.")], port: Port = None, baud: Baud = 115200
):
    """Change the speed now, up to the next speed in the file; also answers a +0.

    Example: passo pulses speed 300
    """
    _send_order(("speed", mm_min), port, baud, wait=False)


@app.command(context_settings=_NUMBERS)
def jog(
    words: Annotated[list[str], typer.Argument(metavar="AXIS MM …", help="For example: x 10 y -5")],
    steps: Annotated[bool, typer.Option("--steps", help="The numbers are steps.")] = False,
    board: BoardName = BOARD, port: Port = None, baud: Baud = 115200, wait: Wait = True,
):  # fmt: skip
    """Move by hand, one axis after the other, at the board's default speed and in its own steps/mm.

    Examples:

        passo pulses jog z -0.5
        passo pulses jog x 800 y -800 --steps
    """
    from host_tools import boards
    from host_tools.cli import ports
    from host_tools.running_board import as_running

    port = port or ports.only_port()
    config, whose = as_running(boards.load(board), "pulses", None if steps else port, baud)
    axes = {axis["name"]: axis["steps_per_m"] / 1000 for axis in config["axes"]}
    if len(words) % 2:
        raise Failure("an axis and a number are wanted, as in x 10 y -5, not {}", " ".join(words))
    order = ["jog"]
    for axis, number in zip(words[::2], words[1::2]):
        try:
            count = round(float(number) * (1 if steps else axes[axis]))
        except (KeyError, ValueError, OverflowError):
            raise Failure("{} {}: an axis ({}) and a number are wanted", axis, number, ", ".join(axes)) from None
        order += [axis, count]
    if not steps:
        print(whose)
    _send_order(order, port, baud, wait)


def _add_switch(name):
    """Add a verb that switches an output of the machine by hand."""

    def set_switch(state: Annotated[str, typer.Argument(metavar="on|off")], port: Port = None, baud: Baud = 115200):
        """Switch it on or off. Raises Failure."""
        if state not in ("on", "off"):
            raise Failure("{} on or off, not {}", name, state)
        _send_order((name, state), port, baud)

    set_switch.__doc__ = f"Switch the {name} by hand, at a stand.\n\nExample: passo pulses {name} on"
    app.command(name)(set_switch)


for _name in ("tool", "drives"):
    _add_switch(_name)


@app.command()
def status(
    watch: Annotated[bool, typer.Option("--watch", help="Again and again, until Ctrl-C.")] = False,
    port: Port = None, baud: Baud = 115200,
):  # fmt: skip
    """Show state, progress, speed, position, the rest of a wait, and the image of the port.

    Example: passo pulses status --watch
    """
    import time

    from host_tools.cli.pulses_panel import status_text
    from host_tools.clients.pulses import POLL_S

    with _connect_client(port, baud) as client:
        try:
            while True:
                print(status_text(client.status()), flush=True)
                if not watch:
                    return
                time.sleep(POLL_S)
        except KeyboardInterrupt:
            return


for _verb in (check, convert, ramps, image, example):
    app.command()(_verb)
