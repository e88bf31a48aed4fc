"""`passo jobs`: programs kept on a board, which run without a PC."""

import base64
import contextlib
import re
import time
from functools import partial
from pathlib import Path
from typing import Annotated, Optional

import typer

from host_tools.cli.options import AnyBaud, Port
from host_tools.failure import Failure
from host_tools.language import _, count_text
from passo import errors
from passo.protocols.pulses.errors import NO_CONTROL

app = typer.Typer(help="Programs kept on the board: list, store, check, delete and run them.", no_args_is_help=True)

_BYTES_A_LINE = 54
_VERIFY_S = 120.0
_MOST_UNSAID = 100  # ten seconds: not every report has room for it
_RUNNING = re.compile(r"\[JOB:([^|]*)\|(\d+)\]")
_FREE = re.compile(r"\[FREE:(\d+)\]")
_MORE = re.compile(r"\[MORE:(\d+)\]")
_UNKNOWN = (errors.STATEMENT, NO_CONTROL)

Protocol = Annotated[str, typer.Option(help="What the link of --port speaks: grbl, pulses or plotter.")]


@contextlib.contextmanager
def _connect_client(port, baud, protocol):
    """Give a client of the language; its ask(line) sends `$F` lines. Raises Failure if the board refuses a line because a stored job runs."""
    from host_tools.cli import ports
    from host_tools.cli.link import BAUD
    from host_tools.clients.refusal import Refused
    from host_tools.clients.settings import client_class
    from host_tools.programs.stored_job import KINDS

    if protocol not in KINDS:
        raise Failure("--protocol is {}, not {!r}", ", ".join(KINDS), protocol)
    with client_class(protocol)(port or ports.only_port(), baud or BAUD[protocol]) as client:
        if protocol == "grbl":
            client.be_sure_it_stands()
        try:
            yield client
        except Refused as refused:
            # In grbl `?` is a real-time command, also inside `$F?`: be_sure_it_stands() has named the job there.
            if refused.number == errors.COMMANDED_ELSEWHERE and protocol != "grbl" and (running := _RUNNING.search("\n".join(client.ask("$F?")))):
                raise Failure("the stored job {} runs: wait for its end, or stop it", running[1]) from None
            raise


def _list_jobs(client):
    """Return ({name: (bytes, bytes stored, CRC-32, language)}, bytes free, number of further jobs that the list has no room for). Raises Failure if
    the board keeps no jobs."""
    from host_tools.clients.grbl import Refused
    from host_tools.programs.stored_job import LISTED

    try:
        said = client.ask("$F")
    except Refused as refused:
        if refused.number in _UNKNOWN:
            raise Failure("the board keeps no jobs: its board file has no key `jobs` (docs/use/jobs.md)") from None
        raise
    found = {}
    for name, size, stored, crc, language in LISTED.findall("\n".join(said)):
        found[name] = int(size), int(stored), int(crc, 16), language
    free, more = (kind.search("\n".join(said)) for kind in (_FREE, _MORE))
    return found, int(free[1]) if free else 0, int(more[1]) if more else 0


@app.command("list")
def list_(port: Port = None, baud: AnyBaud = None, protocol: Protocol = "grbl"):
    """List the jobs of a board: bytes, bytes in flash, language.

    Example:

        passo jobs list --port /dev/ttyACM0
    """
    with _connect_client(port, baud, protocol) as client:
        found, free, more = _list_jobs(client)
    for name, (size, stored, crc, language) in found.items():
        print(_("{:24} {:9} bytes, {:8} in flash, {}", name, size, stored, language))
    if more:
        print(_("{} more jobs are not listed: each is run, checked and deleted by its name", more))
    print(_("{}, {} kB free", count_text(len(found) + more, "job"), free // 1024))


@app.command()
def store(
    file: Annotated[Path, typer.Argument(help="G-code, a pulse file, or packets of passo draw --packets.")],
    name: Annotated[Optional[str], typer.Option(help="Its name on the board (that of the file, in capitals).")] = None,
    language: Annotated[Optional[str], typer.Option(help="grbl, pulses or plotter: the board file's jobs.language (that of the link).")] = None,
    card: Annotated[Optional[Path], typer.Option(help="Write it on a memory card in this PC: the folder where the card is.")] = None,
    check: Annotated[bool, typer.Option(help="Check each line: here before it is sent, and by the board, in its check mode, once it is stored.")] = True,
    port: Port = None,
    baud: AnyBaud = None,
    protocol: Protocol = "grbl",
):
    """Store a file on the board. It counts once it is there whole: until then, and if anything goes wrong, an older one of
    that name stays.

    Examples:

        passo jobs store part.gcode
        passo jobs store part.gcode --name PART --no-check --port /dev/ttyACM0
        passo jobs store part.gcode --card /media/me/SD
        passo jobs store hexagon.txt --protocol pulses
    """
    from host_tools.clients.grbl import Refused
    from host_tools.programs import stored_job

    language = language or protocol
    if language not in stored_job.KINDS:
        raise Failure("--language is {}, not {!r}", ", ".join(stored_job.KINDS), language)
    make, unit, count = stored_job.KINDS[language]
    data = make(file, partial(_print_end, file)) if language == "grbl" else make(file)
    packed = stored_job.pack_job(data)
    name = (name or stored_job.name_of(file)).upper()
    if card:
        written = stored_job.write_on_card(card, name, language, data)
        print(_("{}: {} bytes, {} on the card", written, len(data), written.stat().st_size))
        return
    with _connect_client(port, baud, protocol) as client:
        free = _list_jobs(client)[1]
        if check and language == "grbl":
            _check_here(client, file)
        if len(packed) > free:
            raise Failure("{} takes {} bytes of flash; {} are free: delete a job (passo jobs list)", file, len(packed), free)
        begun = time.monotonic()
        client.ask(f"$FS={name},{language},{len(data)},{stored_job.crc_of(data):08x},{len(packed)}")
        with _bar(_("storing {}", name)) as show:
            for first in range(0, len(packed), _BYTES_A_LINE):
                client.ask("$F:" + base64.b64encode(packed[first : first + _BYTES_A_LINE]).decode())
                show(first / len(packed))
        client.ask("$FE", _VERIFY_S)
        took, each = time.monotonic() - begun, len(packed) / max(count(data), 1)
        print(_("{}: {} bytes, {} in flash, {:.2g} a {}, in {:.0f} s", name, len(data), len(packed), each, _(unit), took))
        if check and language == protocol == "grbl":
            if client.ask_status()["state"] != "Idle":
                print(_("{0} has not been checked line by line: the machine is not idle. Home it, then: passo jobs check {0}", name))
                return
            try:
                _check_stored(client, name)
            except Refused as refused:
                raise Failure("{} is stored, but not right: {}", name, refused) from None


def _print_end(file, number, behind):
    """Print that a program ends at line `number`, and how many lines stand behind it."""
    print(_("{} ends at line {}; what stands behind it is no part of the program: {}", file.name, number, count_text(behind, "line")))


def _check_here(client, file):
    """Parse the file as the firmware would with the machine's settings. Raises Failure at the first line refused; nothing on the board changes."""
    from host_tools.programs import gcode_file
    from host_tools.programs.program_makers import advice_of
    from host_tools.programs.replay import Replay
    from host_tools.programs.replay_machine import Machine

    machine = Machine.of_answers(client.command("$$"), client.command("$#"), client.command("$I"))
    try:
        Replay(machine, gcode_file.read(file)).check()
    except Failure as failure:
        if advice := advice_of(file):
            typer.echo(f"{file.name}: {advice}", err=True)
        raise Failure("{}, {}; nothing was stored", file, failure) from None


def _check_stored(client, name):
    """Run a stored job in check mode ($C), without motion; a reset ends it. Raises Failure if the machine is not idle, Refused at the job's first
    error."""
    if client.ask_status()["state"] != "Idle":
        raise Failure("the machine has to be idle: home or unlock it first")
    client.command("$C")
    try:
        _run_job(client, name, _("checking {}", name))
    finally:
        client.reset()
    print(_("{}: every line is understood", name))


@app.command("check")
def check_(name: Annotated[str, typer.Argument(help="The job.")], port: Port = None, baud: AnyBaud = None, protocol: Protocol = "grbl"):
    """Have the board check every line of a stored job, without moving.

    Example:

        passo jobs check PART.GCODE
    """
    if protocol != "grbl":
        raise Failure("G-code is checked by the board; other files are checked whole when they are stored")
    with _connect_client(port, baud, protocol) as client:
        _check_stored(client, name.upper())


@app.command()
def delete(name: Annotated[str, typer.Argument(help="The job.")], port: Port = None, baud: AnyBaud = None, protocol: Protocol = "grbl"):
    """Delete a stored job.

    Example:

        passo jobs delete PART.GCODE
    """
    with _connect_client(port, baud, protocol) as client:
        client.ask(f"$FD={name.upper()}")


@app.command()
def run(
    name: Annotated[str, typer.Argument(help="The job.")],
    home: Annotated[bool, typer.Option(help="Home the machine first.")] = False,
    wait: Annotated[bool, typer.Option(help="Show progress until the job has ended; otherwise return at once.")] = True,
    port: Port = None,
    baud: AnyBaud = None,
    protocol: Protocol = "grbl",
):
    """Run a stored job. It needs no PC: Ctrl-C ends the watching, not the job. `passo send`, `!` and Ctrl-X of any sender stop it.

    Examples:

        passo jobs run PART.GCODE --home
        passo jobs run PART.GCODE --no-wait
    """
    with _connect_client(port, baud, protocol) as client:
        if home:
            client.home()
        if wait:
            (_run_job if protocol == "grbl" else _watch_job)(client, name.upper(), _("running {}", name.upper()))
            print(_("{}: done", name.upper()))
        else:
            client.ask(f"$F={name.upper()}")


def _run_job(client, name, text):
    """Run a job to its end, with `text` and progress from the reports. Raises Refused if it ends with an error, LinkError if the board is silent, or
    reports no job for ten seconds."""
    from host_tools.clients.grbl import LinkError, Refused, alarm_text, explain_error

    client.ask(f"$F={name}")
    heard = client.rest
    unsaid = 0  # reports without a word of the job
    with _bar(text) as show:
        while unsaid < _MOST_UNSAID:
            for line in heard:
                if line.startswith("error:"):
                    raise Refused("{}", explain_error(line))
                if line == f"[MSG:Job {name} done]":
                    return
                ended = re.match(rf"\[MSG:Job {re.escape(name)}: error (\d+)(?: in line (\d+))?\]", line)
                if ended:
                    alarm = client.alarm and _("alarm {}: {}", client.alarm, alarm_text(client.alarm))
                    why = alarm or explain_error(f"error:{ended[1]}")
                    raise Refused("line {}: {}", ended[2], why) if ended[2] else Refused("{}", why)
            if client.is_silent():
                raise LinkError("{}: no answer any more; the job goes on without it", client.port)
            time.sleep(0.1)
            client.real_time(b"?")
            shown = client.status.get("SD")
            unsaid = 0 if shown else unsaid + 1
            if shown:
                show(int(shown.partition(",")[0]) / 100)
            heard = client.read_lines()
    raise LinkError("{}: the board says nothing of {} any more: it has ended, and its last message was lost", client.port, name)


def _watch_job(client, name, text):
    """Run a job to its end in a language without reports: ask `$F?` five times a second. Raises Refused if it ends with an error."""
    from host_tools.clients.refusal import Refused, explain_error

    client.ask(f"$F={name}")
    with _bar(text) as show:
        while True:
            time.sleep(0.2)
            said = client.ask("$F?")
            if under_way := _RUNNING.search("\n".join(said)):
                show(int(under_way[2]) / 100)
                continue
            ended = re.search(rf"\[ENDED:{re.escape(name)}\|(\d+)\|(\d+)\]", "\n".join(said))
            if not ended or ended[1] != "0":
                raise Refused("{}: {}", name, explain_error("error:" + ended[1]) if ended else _("the board has been reset"))
            return


class _bar:
    """A progress bar on a terminal, nothing elsewhere: `with _bar(text) as show: show(share)`."""

    def __init__(self, text):
        self._text = text
        self._progress = None

    def __enter__(self):
        import sys

        if sys.stderr.isatty():
            from host_tools.cli.stream import progress_bar

            self._progress = progress_bar(True)
            self._progress.start()
            self._task = self._progress.task_ids[0]
        return self._show_share

    def _show_share(self, share):
        """Show the share of the job that is done, 0 … 1."""
        if self._progress:
            self._progress.update(self._task, completed=share, description=self._text, refresh=True)

    def __exit__(self, *_):
        if self._progress:
            self._progress.stop()
