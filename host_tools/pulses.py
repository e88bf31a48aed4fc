"""`passo pulses`: files of pulse codes, as LPTControl played them: played, turned round, repeated, checked, converted."""

import sys
from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools.failure import Failure

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

Port = Annotated[Optional[str], typer.Option(help="Serial port, pty or pyserial URL (socket://host:port).")]
Baud = Annotated[int, typer.Option(help="Bits per second of a serial port.")]
Log = Annotated[Optional[Path], typer.Option(help="Save what is said on the wire to this file.")]
BoardName = Annotated[str, typer.Option("--board", help="Board file: a name of boards/, or the path of a .py file.")]
PulseFile = Annotated[Path, typer.Argument(help="The pulse file.")]
Out = Annotated[Optional[Path], typer.Option("-o", "--out", help="The file to write.")]
Back = Annotated[bool, typer.Option("--back", help="And then backward.")]
Wait = Annotated[bool, typer.Option("--wait/--no-wait", help="Show position and state until the machine stands.")]
BOARD = "lpt_router"


def _client(port, baud, log=None):
    from host_tools import ports
    from host_tools.pulses_client import PulsesClient

    return PulsesClient(port or ports.only(), baud, log)


def status_text(status):
    """A status in one line for people."""
    parts = [f"{status['state']:<5} command {status['at']} of {status['of']}"]
    if status["pass"] != "1/1":
        parts.append(f"pass {status['pass']}")
    parts.append(f"{'backward' if status['going'] == '-' else 'forward'} at {status['speed']} mm/min")
    if status["wait"] != "0":
        parts.append(f"waits {int(status['wait']) / 1000:.1f} s")
    if status["ask"] == "1":
        parts.append("WAITS FOR A SPEED")
    if status["manual"] != "0":
        parts.append(f"{status['manual']} steps by hand")
    parts.append(f"place {status['place']}")
    parts.append(f"tool {'on' if status['tool'] == '1' else 'off'}")
    return ", ".join(parts) + f", port {status['port']}"


def _show(status):
    if sys.stderr.isatty():
        print("\r\x1b[K" + status_text(status), end="", file=sys.stderr, flush=True)


def _follow(client, wait):
    """Show what goes on until the machine stands; Ctrl-C stops it."""
    from host_tools.pulses_client import check

    if not wait:
        return
    try:
        status = client.settle(_show)
    except KeyboardInterrupt:
        client.command("stop")
        raise Failure(f"stopped by Ctrl-C at {status_text(client.status())}") from None
    finally:
        if sys.stderr.isatty():
            print("\r\x1b[K", end="", file=sys.stderr)
    for line in client.said:
        check(line, "the run")
    print(status_text(status))
    if status["state"] == "alarm":
        raise Failure("the machine is in alarm")


def _order(words, port, baud, wait=True):
    with _client(port, baud) as client:
        client.command(*words)
        _follow(client, wait)


# --- on a board


@app.command()
def play(
    file: PulseFile,
    repeat: Annotated[int, typer.Option(min=1, max=100, help="How many times.")] = 1,
    speed: Annotated[Optional[int], typer.Option(min=1, help="mm/min to begin with, up to the file's own.")] = None,
    stream: Annotated[bool, typer.Option("--stream", help="Play it as it is sent; for what is too long to store.")] = False,
    port: Port = None, baud: Baud = 115200, wait: Wait = True, log: Log = None,
):  # fmt: skip
    """Send a file and play it: checked whole and stored on the board first, or streamed.

    Ctrl-C stops. Pause, turn round, change the speed and so on from another terminal, or with --no-wait.

    Examples:

        passo pulses play square.txt

        passo pulses play hexagon.txt --repeat 100 --speed 800 --no-wait

        passo pulses play engraving.txt --stream
    """
    from host_tools import pulse_file

    data = pulse_file.load(file)
    if stream and repeat > 1:
        raise Failure("a file that is streamed is played once; leave out --stream or --repeat")
    if stream and not wait:
        raise Failure("to stream a file takes as long as it plays; leave out --no-wait")
    with _client(port, baud, log) as client:
        try:
            if stream and speed:
                client.command("speed", speed)
            count = client.send_file(data, stream)
        except KeyboardInterrupt:
            client.command("stop")
            raise Failure("stopped by Ctrl-C") from None
        print(f"{file}: {count} commands")
        if not stream:
            if speed:
                client.command("speed", speed)
            client.command("run", repeat)
        _follow(client, wait)


@app.command()
def run(
    times: Annotated[Optional[int], typer.Argument(min=1, max=100, help="How many times.")] = None,
    port: Port = None, baud: Baud = 115200, wait: Wait = True,
):  # fmt: skip
    """Play the stored file, or go on after a pause."""
    _order(("run", times) if times else ("run",), port, baud, wait)


@app.command()
def reverse(port: Port = None, baud: Baud = 115200, wait: Wait = True):
    """Play backward from where it is, to the start of the file; `run` goes forward again."""
    _order(("back",), port, baud, wait)


@app.command()
def pause(port: Port = None, baud: Baud = 115200):
    """Pause at the next step."""
    _order(("pause",), port, baud)


@app.command()
def stop(port: Port = None, baud: Baud = 115200):
    """Stop at once, the tool off; the file is at its start again."""
    _order(("stop",), port, baud)


@app.command()
def step(back: Back = False, port: Port = None, baud: Baud = 115200):
    """One command of the file; --back: the last one backward."""
    _order(("step", "back") if back else ("step",), port, baud)


@app.command("return")
def return_(back: Back = False, port: Port = None, baud: Baud = 115200, wait: Wait = True):
    """Go back the way the moves by hand came, and on with the file."""
    _order(("return", "back") if back else ("return",), port, baud, wait)


@app.command("continue")
def continue_(back: Back = False, port: Port = None, baud: Baud = 115200, wait: Wait = True):
    """Forget the moves by hand and go on with the file from here."""
    _order(("continue", "back") if back else ("continue",), port, baud, wait)


@app.command()
def repeat(times: Annotated[int, typer.Argument(min=1, max=100)], port: Port = None, baud: Baud = 115200):
    """How many times the file is played."""
    _order(("repeat", times), port, baud, wait=False)


@app.command()
def speed(
    mm_min: Annotated[int, typer.Argument(min=1, help="mm/min along the path.")], port: Port = None, baud: Baud = 115200
):
    """Another speed, now, up to the next one of the file; also what a +0 waits for."""
    _order(("speed", mm_min), port, baud, wait=False)


@app.command(context_settings=_NUMBERS)
def jog(
    words: Annotated[list[str], typer.Argument(metavar="AXIS MM …", help="For example: x 10 y -5")],
    steps: Annotated[bool, typer.Option("--steps", help="The numbers are steps.")] = False,
    board: BoardName = BOARD, port: Port = None, baud: Baud = 115200, wait: Wait = True,
):  # fmt: skip
    """Move by hand, one axis after the other, at the board file's speed.

    Examples:

        passo pulses jog z -0.5

        passo pulses jog x 800 y -800 --steps
    """
    from host_tools import boards

    axes = {axis["name"]: axis["steps_per_m"] / 1000 for axis in boards.load(board)["axes"]}
    if len(words) % 2:
        raise Failure(f"an axis and a number are wanted, as in x 10 y -5, not {' '.join(words)}")
    order = ["jog"]
    for axis, number in zip(words[::2], words[1::2]):
        try:
            count = round(float(number) * (1 if steps else axes[axis]))
        except (KeyError, ValueError, OverflowError):
            raise Failure(f"{axis} {number}: an axis ({', '.join(axes)}) and a number are wanted") from None
        order += [axis, count]
    _order(order, port, baud, wait)


def _switch(name):
    def switch(state: Annotated[str, typer.Argument(metavar="on|off")], port: Port = None, baud: Baud = 115200):
        if state not in ("on", "off"):
            raise Failure(f"{name} on or off, not {state}")
        _order((name, state), port, baud)

    switch.__doc__ = f"Switch the {name} by hand, at a stand."
    app.command(name)(switch)


for _name in ("tool", "drives"):
    _switch(_name)


@app.command()
def status(
    watch: Annotated[bool, typer.Option("--watch", help="Again and again, until Ctrl-C.")] = False,
    port: Port = None, baud: Baud = 115200,
):  # fmt: skip
    """Where it is and what it does: the port's image, progress, speed, what a wait still lasts."""
    import time

    from host_tools.pulses_client import POLL_S

    with _client(port, baud) as client:
        try:
            while True:
                print(status_text(client.status()), flush=True)
                if not watch:
                    return
                time.sleep(POLL_S)
        except KeyboardInterrupt:
            return


# --- files


def _board(name):
    from host_tools import boards
    from passo.control.boardfile import BoardError, check

    try:
        board = check(boards.load(name))
    except BoardError as error:
        raise Failure(f"board {name}: {error}") from error
    if not board["track"]:
        raise Failure(f"board {name} has no section track")
    return board, "".join(axis["name"] for axis in board["axes"])[:3]


@app.command()
def check(file: PulseFile, board: BoardName = BOARD):
    """Check a file: errors by line and column, commands, box, time; nothing is sent.

    Examples:

        passo pulses check square.txt
    """
    from host_tools import pulse_file
    from host_tools.gcode_file import clock

    config, axes = _board(board)
    course = pulse_file.Course(pulse_file.items(pulse_file.load(file), axes, config["track"], file), config)
    print(f"commands {course.commands}, {course.steps} of them steps; {clock(course.seconds)} ({course.seconds:.1f} s)")
    for number, axis in enumerate(config["axes"]):
        per_mm = axis["steps_per_m"] / 1000
        low, high, end = (place[number] / per_mm for place in (course.low, course.high, course.place))
        print(f"{axis['name'].upper()} {low:9.3f} … {high:9.3f} mm, ends at {end:.3f}")


@app.command()
def convert(
    file: Annotated[Path, typer.Argument(help="A pulse file, or G-code (.gcode, .nc, .ngc, .tap).")],
    out: Out = None,
    board: BoardName = BOARD,
):
    """A pulse file to a picture, or G-code to a pulse file.

    The picture is a .png, .svg or .pdf: dark where the tool is on. Lines and arcs of G-code are walked as the firmware
    walks them; M3 and M5 switch the tool, G4 waits, M0 asks the operator for the speed.

    Examples:

        passo pulses convert hexagon.txt -o hexagon.png

        passo pulses convert part.gcode -o part.txt
    """
    from host_tools import gcode_file, plot, pulse_file

    config, axes = _board(board)
    if file.suffix.lower() in (".gcode", ".nc", ".ngc", ".tap", ".g"):
        text = pulse_file.Converter(config).convert(gcode_file.read(file))
        target = out or file.with_suffix(".txt")
        try:
            target.write_text(text, encoding="ascii")
        except OSError as error:
            raise Failure(f"cannot write {target}: {error.strerror}") from error
    else:
        course = pulse_file.Course(pulse_file.items(pulse_file.load(file), axes, config["track"], file), config)
        target = out or file.with_suffix(".png")
        plot.save(target, course.strokes, file.stem)
    print(target)


@app.command()
def image(file: PulseFile, board: BoardName = BOARD):
    """The bytes that the parallel port would have shown, command by command, in hex.

    Examples:

        passo pulses image square.txt --board boards/mine.py
    """
    from host_tools import pulse_file
    from passo.protocols.commands import TRACK_DRIVES, TRACK_TOOL
    from passo.protocols.pulses_report import port_byte

    config, axes = _board(board)
    drives = tool = False
    for item in pulse_file.items(pulse_file.load(file), axes, config["track"], file):
        kind = 0 if item & 15 else item >> 4 & 15
        if kind == TRACK_DRIVES:
            drives = bool(item >> 8)
        elif kind == TRACK_TOOL:
            tool = bool(item >> 8) and not config["track"]["dry_run"]
        elif kind:
            continue
        byte = port_byte(item & 255 if item & 15 else 0, tool, drives, config["track"])
        for _ in range(item >> 8 if item & 15 else 1):
            print(f"{byte:02X}")


@app.command()
def example(
    shape: Annotated[str, typer.Argument(help="square, triangle, hexagon or octagon.")],
    out: Out = None,
    speed: Annotated[int, typer.Option(min=1, help="mm/min.")] = 1000,
    down: Annotated[float, typer.Option(min=0, help="How many mm the tool goes down by before it cuts.")] = 0.0,
    board: BoardName = BOARD,
):
    """Write one of the cuts of LPTControl's document: 10 × 10 cm, 10 × 10, 15 × 10 and 15 × 15.

    Examples:

        passo pulses example hexagon -o hexagon.txt --speed 800
    """
    from host_tools import pulse_shapes

    if shape not in pulse_shapes.SHAPES:
        raise Failure(f"{shape!r} is no example; known are {', '.join(sorted(pulse_shapes.SHAPES))}")
    config, _ = _board(board)
    scale = {axis["steps_per_m"] for axis in config["axes"][:2]}
    if len(scale) != 1:
        raise Failure(f"board {board}: X and Y differ in steps/mm, and a diagonal would not be one")
    per_mm = scale.pop() / 1000
    z_per_mm = config["axes"][-1]["steps_per_m"] / 1000
    target = out or Path(f"{shape}.txt")
    try:
        target.write_text(pulse_shapes.text(shape, per_mm, speed, round(down * z_per_mm)), encoding="ascii")
    except OSError as error:
        raise Failure(f"cannot write {target}: {error.strerror}") from error
    print(target)
