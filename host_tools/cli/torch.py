"""`passo torch`: the welding-torch manipulator from a terminal, in millimetres."""

import math
import sys
from typing import Annotated, Optional

import typer

from host_tools.cli.options import Baud, BoardName, Log, Port
from host_tools.failure import Failure
from host_tools.language import _, error_text
from passo.options.independent.commands import FOREVER

app = typer.Typer(
    help="""Drive the torch manipulator: each axis at its own speed to its own target.

    Lengths are millimetres and speeds mm/min, by the steps/mm that the board has kept; by those of the board file, if it is none of Passo. With
    --steps they are steps and steps/s.

    Examples:

        passo torch connect --port /dev/ttyACM0
        passo torch move 10 -5 --speed 600
    """,
    no_args_is_help=True,
)
_NUMBERS = {"ignore_unknown_options": True}  # so that -5 is a number
JOGS = ("x+", "x-", "y+", "y-")

Steps = Annotated[bool, typer.Option("--steps", help="Numbers are steps and steps/s.")]
Wait = Annotated[bool, typer.Option("--wait/--no-wait", help="Show the position until the machine stands.")]
Speed = Annotated[float, typer.Option(min=0.001, help="Of both axes.")]
AxisSpeed = Annotated[Optional[float], typer.Option(min=0.001, help="Of this axis alone.")]
_WINDOW = (100, 101, 150, 151, 170, 171)  # settings that the document's window had
DEFAULT_SPEED = 600.0  # mm/min: the 60 cm/min of the document's measurements


class Units:
    """Converts numbers of the command line to steps."""

    def __init__(self, board, steps, client):
        """Take the steps/mm of the board that `client` is connected to, else those of the board file `board`; with `steps` 1."""
        from host_tools import boards
        from host_tools.running_board import with_client_settings

        self.steps = steps
        self.per_mm = (1.0, 1.0)
        self.whose = ""  # a line that says whose steps/mm count; "" if the board's are the file's
        if not steps:
            file = boards.load(board)
            here, self.whose = with_client_settings(file, client)
            self.per_mm = boards.steps_per_mm(here)
            if here is not file and self.per_mm == boards.steps_per_mm(file):
                self.whose = ""

    def count_steps(self, axis, length):
        """Return a length in whole steps. Raises Failure above 2²⁹ − 2 steps, the most that a frame holds."""
        steps = length * self.per_mm[axis]
        if not _fits_frame(steps):
            raise Failure("too far: {} is {:g}, and at most 2²⁹ − 2 steps go into a move or jog", "xy"[axis], length)
        return round(steps)

    def steps_per_s(self, axis, speed, default):
        """Return a speed (mm/min; steps/s with --steps; None: `default`) in whole steps/s, at least 1. Raises Failure above 2²⁹ − 2 steps/s, the most
        that a frame holds."""
        value = default if speed is None else speed
        steps_s = value if self.steps else value * self.per_mm[axis] / 60
        if not _fits_frame(steps_s):
            raise Failure("too fast: the speed of {} is {:g}, and at most 2²⁹ − 2 steps/s go into a frame", "xy"[axis], value)
        return max(round(steps_s), 1)

    def print_scale(self):
        """Print whose steps/mm count, if they are not the board file's."""
        if self.whose:
            print(self.whose)

    def position_text(self, x, y):
        """Return a position, given in steps, in mm, or in steps with --steps."""
        if self.steps:
            return _("X {} Y {} steps", x, y)
        return f"X {x / self.per_mm[0]:.3f} Y {y / self.per_mm[1]:.3f} mm"


def _fits_frame(value):
    """False for a number that a frame cannot hold: it would come out as another one, or with another sign."""
    return abs(value) < FOREVER - 0.5


def _read_settings(client, numbers):
    """Return the values of settings of the running board, or None if it has no lines about them."""
    from host_tools.clients.refusal import Refused

    if client.status() is None:
        return None
    try:
        return tuple(float(client.ask(f"${number}")[0].partition("=")[2]) for number in numbers)
    except Refused:
        return None  # an older firmware


def _connect_client(port, baud, log):
    """Return a TorchClient on the port, or on the only board. Raises Failure."""
    from host_tools.cli import ports
    from host_tools.clients.torch import TorchClient

    return TorchClient(port or ports.only_port(), baud, log=log)


def status_text(units, status):
    """Return a status in one line for people: state, position, whose the motors are."""
    motors = {True: _(", motors here"), False: _(", motors with the other controller"), None: ""}[status["ours"]]
    return f"{status['state']:<5} {units.position_text(status['x'], status['y'])}{motors}"


def _wait_and_show(client, units, wait):
    """Show the position until the machine is at rest; Ctrl-C stops it. Returns at once without `wait`. Raises Failure."""
    if not wait:
        return
    live = sys.stderr.isatty()

    def show_status(status):
        """Show a status in place, at a terminal."""
        if live:
            print("\r\x1b[K" + status_text(units, status), end="", file=sys.stderr, flush=True)

    try:
        status = client.wait(show_status)
    except KeyboardInterrupt:
        x, y = client.counts("STOP")
        raise Failure("stopped by Ctrl-C after {}", units.position_text(x, y)) from None
    finally:
        if live:
            print("\r\x1b[K", end="", file=sys.stderr)
    print(status_text(units, status))


def _send_move(client, units, lengths, speeds, wait):
    """Send a move by `lengths` (mm; steps with --steps) at `speeds` (steps/s), one of each axis, and wait for its end. Raises Failure."""
    from passo.protocols.torch import protocol as torch

    fields = []
    for axis in range(2):
        count = units.count_steps(axis, lengths[axis])
        fields += [abs(count), speeds[axis] if count >= 0 else -speeds[axis]]
    client.order(torch.move(*fields))
    _wait_and_show(client, units, wait)


@app.command(context_settings=_NUMBERS)
def move(
    x: Annotated[float, typer.Argument(help="How far, from where the last move ended.")],
    y: Annotated[float, typer.Argument()],
    speed: Speed = DEFAULT_SPEED, x_speed: AxisSpeed = None, y_speed: AxisSpeed = None, steps: Steps = False,
    board: BoardName = "torch_manipulator", port: Port = None, baud: Baud = 115200, wait: Wait = True, log: Log = None,
):  # fmt: skip
    """Move both axes, each at its own speed to its own target.

    Examples:

        passo torch move 10 0
        passo torch move 20 -7.5 --speed 300 --y-speed 120
        passo torch move 480 830 --steps --x-speed 480 --y-speed 830
    """
    with _connect_client(port, baud, log) as client:
        units = Units(board, steps, client)
        speeds = units.steps_per_s(0, x_speed, speed), units.steps_per_s(1, y_speed, speed)
        units.print_scale()
        _send_move(client, units, (x, y), speeds, wait)


@app.command()
def strokes(
    axis: Annotated[str, typer.Argument(help="x or y.")],
    lengths: Annotated[str, typer.Option(metavar="MM,MM…", help="What is drawn, and measured afterwards.")] = "10,20,50,100",
    strokes_: Annotated[int, typer.Option("--strokes", min=2, max=100, help="Of each length.")] = 10,
    speed: Speed = DEFAULT_SPEED, board: BoardName = "torch_manipulator", port: Port = None, baud: Baud = 115200, log: Log = None,
):  # fmt: skip
    """Draw the square waves of the calibration, from where the torch stands, and come back: with a pen in its place, or with the torch.

    The tool is switched by hand: between two lengths it has to be off. `passo calibrate` takes what you measure.

    Examples:

        passo torch strokes x --port /dev/ttyACM0
        passo torch strokes y --lengths 20,50 --strokes 4
    """
    from host_tools.cli.calibrate import parse_lengths
    from host_tools.programs.calibration import square_waves

    if axis not in ("x", "y"):
        raise Failure("strokes are drawn along x or y, not {!r}", axis)
    wanted, at = parse_lengths(lengths), (0.0, 0.0)
    live = sys.stdin.isatty()
    with _connect_client(port, baud, log) as client:
        units = Units(board, False, client)
        units.print_scale()
        speeds = units.steps_per_s(0, None, speed), units.steps_per_s(1, None, speed)
        for length, x, y in [*square_waves(axis, wanted, strokes_), (None, 0.0, 0.0)]:
            if length is not None:
                print(_("strokes of {:g} mm", length))
            if (x, y) != at:
                _send_move(client, units, (x - at[0], y - at[1]), speeds, True)
            if length is not None and live:
                input(_("tool on, then Enter "))
            at = x, y


@app.command(context_settings=_NUMBERS)
def goto(
    x: Annotated[float, typer.Argument(help="Target, from the origin.")],
    y: Annotated[float, typer.Argument()],
    speed: Speed = DEFAULT_SPEED, x_speed: AxisSpeed = None, y_speed: AxisSpeed = None, steps: Steps = False,
    board: BoardName = "torch_manipulator", port: Port = None, baud: Baud = 115200, wait: Wait = True, log: Log = None,
):  # fmt: skip
    """Go to a position, counted from the origin.

    Examples:

        passo torch goto 0 0
    """
    with _connect_client(port, baud, log) as client:
        units = Units(board, steps, client)
        speeds = units.steps_per_s(0, x_speed, speed), units.steps_per_s(1, y_speed, speed)
        status = client.status()
        if status is None:
            raise Failure("this board does not say where it is; use move")
        at = status["x"], status["y"]
        lengths = [target - place / per_mm for target, place, per_mm in zip((x, y), at, units.per_mm)]
        _send_move(client, units, lengths, speeds, wait)


@app.command()
def jog(
    direction: Annotated[str, typer.Argument(help="x+, x-, y+ or y-.")],
    times: Annotated[int, typer.Option(min=1, max=1000, help="Number of jogs, as one motion.")] = 1,
    steps: Steps = False,
    board: BoardName = "torch_manipulator", port: Port = None, baud: Baud = 115200, wait: Wait = True, log: Log = None,
):  # fmt: skip
    """Move one axis by the configured jog; several jogs run without a gap.

    Examples:

        passo torch jog x+
        passo torch jog y- --times 10
    """
    if direction.lower() not in JOGS:
        raise Failure("jog {} or {}, not {!r}", ", ".join(JOGS[:3]), JOGS[3], direction)
    with _connect_client(port, baud, log) as client:
        units = Units(board, steps, client)
        client.jog(direction.upper(), times)
        _wait_and_show(client, units, wait)


@app.command()
def info(
    watch: Annotated[bool, typer.Option("--watch", help="Go on until Ctrl-C.")] = False, steps: Steps = False,
    board: BoardName = "torch_manipulator", port: Port = None, baud: Baud = 115200, log: Log = None,
):  # fmt: skip
    """Show position, state, and the way since the last move or jog.

    Examples:

        passo torch info
        passo torch info --watch --steps
    """
    import time

    with _connect_client(port, baud, log) as client:
        units = Units(board, steps, client)
        try:
            while True:
                made = client.counts()
                status = client.status()
                text = _("made {}", units.position_text(*made))
                if status:
                    text = _("{}; {}; {} dropped", status_text(units, status), text, status["dropped"])
                    if status["error"]:
                        text += _("; error {}, {}", status["error"], error_text(status["error"]))
                print(text, flush=True)
                if not watch:
                    return
                time.sleep(0.2)
        except KeyboardInterrupt:
            return


@app.command()
def halt(
    steps: Steps = False, board: BoardName = "torch_manipulator", port: Port = None, baud: Baud = 115200, log: Log = None,
):
    """Stop at once; show how far the last move or jog came.

    Examples:

        passo torch halt
    """
    with _connect_client(port, baud, log) as client:
        made = client.counts("STOP")
        print(_("stopped after {}", Units(board, steps, client).position_text(*made)))


@app.command(context_settings=_NUMBERS)
def weave(
    x: Annotated[float, typer.Argument(help="Where the seam ends, from here, in mm.")],
    y: Annotated[float, typer.Argument()],
    shape: Annotated[str, typer.Option(help="zigzag, triangle, trapezoid or sine.")] = "zigzag",
    amplitude: Annotated[float, typer.Option(min=0.001, max=100, help="mm to each side.")] = 3.0,
    pitch: Annotated[float, typer.Option(min=0.1, max=1000, help="mm along the seam.")] = 4.0,
    left: Annotated[int, typer.Option(min=0, max=60_000, help="ms at the left edge.")] = 0,
    right: Annotated[int, typer.Option(min=0, max=60_000, help="ms at the right edge.")] = 0,
    centre: Annotated[Optional[str], typer.Option(metavar="X,Y", help="Of an arc: its centre, from here, in mm.")] = None,
    clockwise: Annotated[bool, typer.Option("--clockwise", help="The arc goes so.")] = False,
    along: Annotated[bool, typer.Option("--along", help="The speed is that along the seam, not along the path.")] = False,
    speed: Annotated[float, typer.Option(min=0.1, max=50_000, help="mm/min.")] = DEFAULT_SPEED,
    board: BoardName = "torch_manipulator", port: Port = None, baud: Baud = 115200, wait: Wait = True, log: Log = None,
):  # fmt: skip
    """Weave along a line or an arc. The board file has to have a section `weaving`.

    Examples:

        passo torch weave 40 0 --shape trapezoid --left 200 --right 200
        passo torch weave 20 20 --centre 0,20 --amplitude 2
    """
    from passo.options.weaving import language_torch
    from passo.options.weaving.motion import NAMES

    if shape not in NAMES[1:]:
        raise Failure("{!r} is no shape; {}", shape, ", ".join(NAMES[1:]))
    try:
        places = [float(part) for part in (centre or "0,0").split(",")]
    except ValueError:
        places = []
    if len(places) != len("xy") or not all(map(math.isfinite, places)):
        raise Failure("--centre wants two numbers, as in 0,20, not {!r}", centre)
    spec = NAMES.index(shape), round(amplitude * 1000), round(pitch * 1000), left, right, 1 if along else 0
    with _connect_client(port, baud, log) as client:
        units = Units(board, False, client)
        to = [units.count_steps(axis, place) for axis, place in enumerate(places)]
        client.order(language_torch.weave(spec, units.count_steps(0, x), units.count_steps(1, y), max(round(speed * 1000 / 60), 1), tuple(to), clockwise))
        _wait_and_show(client, units, wait)


@app.command()
def origin(port: Port = None, baud: Baud = 115200, log: Log = None):
    """Set the origin to the present position.

    Examples:

        passo torch origin
    """
    _send_order("ORIGIN", port, baud, log)
    print(_("the origin is here"))


@app.command()
def config(
    x_jog: Annotated[Optional[float], typer.Argument(min=0, help="Length of a jog of X.")] = None,
    y_jog: Annotated[Optional[float], typer.Argument(min=0, help="Length of a jog of Y.")] = None,
    speed: Speed = DEFAULT_SPEED, x_speed: AxisSpeed = None, y_speed: AxisSpeed = None, steps: Steps = False,
    scale: Annotated[Optional[str], typer.Option("--steps-per-mm", metavar="X,Y", help="Set the board's steps/mm first.")] = None,
    board: BoardName = "torch_manipulator", port: Port = None, baud: Baud = 115200, log: Log = None,
):  # fmt: skip
    """Show or set steps/mm, length and speed of a jog. The board keeps them, also without power.

    They are settings of the board like any other: `passo settings` has all of them, with their bounds. New steps/mm make the position unknown:
    set the origin again.

    Examples:

        passo torch config
        passo torch config --steps-per-mm 49.218,81
        passo torch config 1 1 --speed 600
        passo torch config 48 83 --steps --x-speed 480 --y-speed 830
    """
    from passo.protocols.torch import protocol as torch

    if (x_jog is None) != (y_jog is None):
        raise Failure("config wants the jogs of both axes, or of none")
    with _connect_client(port, baud, log) as client:
        for number, value in zip((100, 101), _parse_scale(scale)):
            client.ask(f"${number}={value:.3f}")
        if x_jog is None:
            _show_settings(client)
            return
        units = Units(board, steps, client)
        jogs = units.count_steps(0, x_jog), units.count_steps(1, y_jog)
        speeds = units.steps_per_s(0, x_speed, speed), units.steps_per_s(1, y_speed, speed)
        client.order(torch.configure(*jogs, *speeds))
    print(_("jogs of {} and {} steps at {} and {} steps/s", *jogs, *speeds))


def _parse_scale(text):
    """Return the two numbers of --steps-per-mm; [] if it is not given. Raises Failure unless they are above 0, up to 100,000."""
    try:
        found = [float(part) for part in text.split(",")] if text else []
    except ValueError:
        found = [0.0]
    if found and (len(found) != len("xy") or not all(0 < value <= 100_000 for value in found)):
        raise Failure("--steps-per-mm wants two numbers above 0, as in 49.218,81, not {!r}", text)
    return found


def _show_settings(client):
    """Print the settings that the window of 2020 had. Raises Failure if the board has no lines about them."""
    from host_tools.clients.setting_names import describe_lines

    kept = _read_settings(client, _WINDOW)
    if kept is None:
        raise Failure("this board has no such word")
    print("\n".join(describe_lines([f"${number}={value:.3f}" for number, value in zip(_WINDOW, kept)])))


@app.command()
def connect(port: Port = None, baud: Baud = 115200, log: Log = None):
    """Take the motors from the original controller.

    Examples:

        passo torch connect
    """
    _send_order("CONNECT", port, baud, log)
    print(_("the motors are this board's"))


@app.command()
def disconnect(port: Port = None, baud: Baud = 115200, log: Log = None):
    """Give the motors back to the original controller.

    Examples:

        passo torch disconnect
    """
    _send_order("DISCONNECT", port, baud, log)
    print(_("the motors are the original controller's"))


@app.command()
def unlock(port: Port = None, baud: Baud = 115200, log: Log = None):
    """Leave an alarm. Remove its cause first; the position may be wrong afterwards.

    Examples:

        passo torch unlock
    """
    from passo.protocols.torch import protocol as torch

    with _connect_client(port, baud, log) as client:
        if client.status() is None:
            raise Failure("this board has no such word")
        for value in (1, 0):
            status = client.order(torch.passo(torch.UNLOCK_OF, value))
        if status["state"] == "alarm":
            raise Failure("the alarm is still there")
    print(_("unlocked"))


@app.command()
def admit(
    minutes: Annotated[int, typer.Argument(min=0, max=60, help="For so long; 0: no longer.")],
    port: Port = None, baud: Baud = 115200, log: Log = None,
):  # fmt: skip
    """Let the program of 2020, which has no key, move the machine over the board's Wi-Fi for some minutes.

    The board file has to allow it: "network": {"legacy_http": True}. A restart of the board or an alarm ends it.

    Examples:

        passo torch admit 30 --port /dev/ttyUSB0
    """
    from passo.protocols.torch import protocol as torch

    with _connect_client(port, baud, log) as client:
        client.order(torch.passo(torch.ADMIT_OF, minutes))
    print(_("admitted for {} minutes", minutes) if minutes else _("no longer admitted"))


def _send_order(name, port, baud, log):
    """Send an order without fields by its name. Raises Failure if the board refuses."""
    from passo.protocols.torch import protocol as torch

    with _connect_client(port, baud, log) as client:
        client.order(torch.frame(name))
