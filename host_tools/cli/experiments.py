"""`passo experiments`: the five documents' experiments again, beside their authors' figures."""

import sys
from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools import language
from host_tools.failure import Failure
from host_tools.language import _


def experiments(
    names: Annotated[Optional[list[str]], typer.Argument(metavar="NAME", help="Which of --list; all unless given.")] = None,
    on: Annotated[str, typer.Option("--on", metavar="virtual|emulated|PORT", help="Where: the virtual machine, the emulated Pico, or a board's serial port (passo ports).")] = "virtual",
    out: Annotated[Path, typer.Option("--out", metavar="FOLDER", help="Where report.html and table.csv are written.")] = Path("experiments"),
    lang: Annotated[Optional[str], typer.Option("--lang", metavar="pt|en", help="Language of the report; that of the command unless given.")] = None,
    moves: Annotated[bool, typer.Option("--moves", help="A board may drive its pins and home, without asking: the machine is clear, the emergency stop at hand.")] = False,
    list_: Annotated[bool, typer.Option("--list", help="Show the experiments and where each can be measured, and end.")] = False,
):
    """Repeat the experiments of the five documents, and write a page and a table of the authors' figures beside one's own.

    The virtual machine takes some seconds, the emulated Pico some minutes: it needs MicroPython's UF2, as passo emulate does. A board computes the lines and arcs of
    the documents itself, with its outputs safe; before its pins move or it homes, passo asks. Exit status 1 if one fails, or if a byte or a name is wrong.

    Examples:

        passo experiments
        passo experiments --list
        passo experiments lines drawing --on emulated --out lesson
        passo experiments --on /dev/ttyACM0 --lang pt
    """
    from host_tools.cli.flash import check_port
    from host_tools.experiments.experiments import EXPERIMENTS, check_names
    from host_tools.experiments.places import EMULATED, VIRTUAL, place_of
    from host_tools.experiments.report import write

    if lang is not None:
        if lang not in language.LANGUAGES:
            raise Failure("--lang is en or pt, not {!r}", lang)
        language.choose_language(lang)
    chosen = check_names(names or [])
    if list_:
        for name, each in EXPERIMENTS.items():
            print(f"{name:<8}  {_(each.title)} ({', '.join(each.kinds)})")
        return
    if on not in (VIRTUAL, EMULATED):
        check_port(on)
    with place_of(on, moves) as place:
        place.moves = place.moves or may_drive_pins(place, chosen)
        done, failed = run_experiments(chosen, place)
    html, table = write(out, done, place.title())
    print(_("written: {} and {}", html, table))
    if failed:
        raise typer.Exit(1)


def may_drive_pins(place, names):
    """True if a board's pins may be driven. Asks the user at a terminal, if an experiment drives pins."""
    from host_tools.cli.prove import is_terminal
    from host_tools.experiments.experiments import EXPERIMENTS

    if not any(EXPERIMENTS[name].moves for name in names) or not is_terminal():
        return False
    return typer.confirm(_("The board will drive its STEP and DIR pins, and home. Is the machine clear, and the emergency stop at hand? Then y"))


def run_experiments(names, place):
    """Run experiments at a place; return ([(name, Outcome or the reason why there is none)], True if one failed or has a wrong value)."""
    from host_tools.emulator.copies import CopyFailed
    from host_tools.experiments.experiments import why_not_here, run

    done, failed = [], False
    for number, name in enumerate(names, 1):
        print_progress(f"{number}/{len(names)} {name}")
        try:
            outcome = why_not_here(name, place)
            if outcome:
                print_progress(f"{name}: {outcome}")
            else:
                outcome = run(name, place)
                failed = failed or any(row.agrees is False for row in outcome.rows)
        except (Failure, OSError, CopyFailed) as error:
            outcome, failed = error.message() if isinstance(error, Failure) else str(error).strip().splitlines()[-1], True
            print_progress(f"{name}: {outcome}")
        except KeyboardInterrupt:
            return [*done, (name, _("interrupted"))], True
        done.append((name, outcome))
    return done, failed


def print_progress(text):
    """Print a line on stderr for a user who waits."""
    print(text, file=sys.stderr, flush=True)
