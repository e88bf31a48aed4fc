"""`passo log`: the errors and alarms of a board since its start, of all links."""

import contextlib
import time

from host_tools.cli.options import AnyBaud, Port, Protocol
from host_tools.failure import Failure
from host_tools.language import _, error_text

_ANSWER_S = 1.0
_MOST_BEFORE = 2000  # bytes that a board says by itself before its answer: its banner, messages
_QUIET_S = 0.02  # silence that separates the next bytes from the question
_WHY_LENGTH = 2  # a board of keys: `?` and the error of the last key
BAUD = {"grbl": 115_200, "torch": 115_200, "pulses": 115_200, "plotter": 57_600}


def log(
    port: Port = None,
    baud: AnyBaud = None,
    protocol: Protocol = None,
):
    """Show the last errors and alarms of all links; grbl also says how many of each there were since the start.

    There is one log for all links: a grbl, torch or pulses link also shows what a link without a word for "no" was refused. A
    plotter link tells the last error only.

    Example: passo log --port /dev/ttyACM0

    Example: passo log --port /dev/ttyUSB0 --protocol pulses
    """
    protocol, port, baud = find_link(port, baud, protocol)
    for line in {"grbl": _lines_of_grbl, "torch": _lines_of_torch, "pulses": _lines_of_pulses, "plotter": _lines_of_plotter}[protocol](port, baud):
        print(line)


def find_link(port, baud, protocol):
    """Return (language, port, baud) of the link to ask, from the options; find those left out. Raises Failure."""
    from host_tools.cli import ports

    if protocol not in (None, *BAUD):
        raise _no_word_failure(protocol)
    port = port or ports.only_port()
    baud = baud or BAUD[protocol or "grbl"]
    return protocol or find_language(port, baud), port, baud


def _no_word_failure(language):
    """Return the Failure of a language without words for status and log."""
    return Failure("--protocol {}: it has no word for the status and the log; ask on a link that speaks {}", language, ", ".join(BAUD))


def find_language(port, baud, known=BAUD):
    """Find the language of a link, one of `known`, by asking; takes up to some seconds. `?` moves nothing in any, and no log has it: grbl and pulses
    answer with their status. A board of keys answers with the error of its last key: two bytes, and nothing else may be sent there, for each byte may
    be a key. If nothing answers, five bytes more make a plotter's packet STATUS of it; a torch ignores both, and is asked last. A link that a killed
    program left in frames does not answer in plain text: end that session, then ask again. `passo --no-frames` skips that. A link of another baud
    rate is not found: say --protocol and --baud."""
    from host_tools.clients import serial_port
    from host_tools.clients.frames import OFFER_S, FramedPort
    from host_tools.clients.serial_port import open_port
    from passo.protocols.plotter.host import COMMANDS, STATUS_LENGTH, packet

    status_packet = packet(COMMANDS["STATUS"])  # its first byte is grbl's `?`

    def ask_status(line):
        """Send `?`, and the rest of a plotter's STATUS if nothing comes; return the answer from its status on, b"" for none."""
        line.timeout = _ANSWER_S
        line.write(status_packet[:1])
        said = line.read(9)
        if not said:
            line.write(status_packet[1:])
            return line.read(STATUS_LENGTH)
        while said[:1] != status_packet[:1] and not set(said) & set(b"<\0") and len(said) < _MOST_BEFORE:
            more = line.read(9)
            if not more:
                break
            said += more
        status = said.find(b"<")
        return said if status < 1 else said[status:] + line.read(1)

    said = _ask_and_close(open_port(port, baud), ask_status)
    if said[:1] == status_packet[:1] and len(said) == _WHY_LENGTH:
        if "keys" in known:
            return "keys"
        raise _no_word_failure("keys")
    if not said and _is_torch(port, baud):
        return "torch"
    if not said or b"\0" in said:
        if serial_port.frames is not False:
            with contextlib.suppress(OSError):  # a session that does not end: the language is not found then, and the caller says so
                _ask_and_close(FramedPort(open_port(port, baud)), lambda line: line.begin(OFFER_S))
        said = _ask_and_close(open_port(port, baud), ask_status)  # a board may have been busy, too
    if said[:1] == b"<":
        return "grbl" if said[1:2].isupper() else "pulses"
    if said[:1] == status_packet[:1] and len(said) == STATUS_LENGTH:
        return "plotter"
    return "torch"


def _is_torch(port, baud):
    """True if the board answers the torch's question for its status."""
    from host_tools.clients.torch import TorchClient

    with TorchClient(port, baud) as client:
        return client.status() is not None


def _ask_and_close(line, ask):
    """Return ask(line) and close `line`; then wait 20 ms, so that the board takes the next bytes for something new."""
    try:
        return ask(line)
    finally:
        line.close()
        time.sleep(_QUIET_S)


def _lines_of_grbl(port, baud):
    """Return the lines of a grbl link's $LOG, for people. Raises Failure."""
    from host_tools.clients.grbl import GrblClient

    with GrblClient(port, baud) as client:
        return [text for text in map(log_line_text, client.command("$LOG")) if text]


def _lines_of_torch(port, baud):
    """Return the lines of a torch link's log, for people. Raises Failure if the board keeps none."""
    from host_tools.clients.torch import TorchClient

    with TorchClient(port, baud) as client:
        entries = client.log()
    if entries is None:
        raise Failure("{}: no answer, or a board that keeps no log; is it one of --protocol {}?", port, ", ".join(BAUD))
    return entry_lines(entries)


def _lines_of_pulses(port, baud):
    """Return the lines of a pulses link's log, for people. Raises Failure."""
    from host_tools.clients.pulses import PulsesClient

    with PulsesClient(port, baud) as client:
        return entry_lines(client.log())


def _lines_of_plotter(port, baud):
    """Return one line with the last error that a plotter link keeps; the board forgets it then. Raises Failure."""
    from host_tools.clients.plotter import PlotterClient
    with PlotterClient(port, baud) as client:
        number = client.status()["error"]
    return [_("the last: {:>3}  {}", number, error_text(number)) if number else _("nothing since it was last asked")]


def entry_lines(entries):
    """Return a line of each entry (ms, number, link) of a log, or one that says that it is empty."""
    return [entry_text(*entry) for entry in entries] or [_("nothing since the start")]


def entry_text(ms, number, who):
    """Return a line of an entry: seconds since the start, link, number and meaning of the error or alarm."""
    return f"{ms / 1000:12.3f} s  {who:<10} {number:>3}  {error_text(number)}"


def pin_text(name, active, trips, glitches, at_ms, lasted_ms):
    """Return a line about an input of the interlock: its state, its trips and glitches since the start, and when and how long it was active last
    (texts of ms; a `lasted_ms` of -1: it still is)."""
    state = _("active") if active == "1" else _("inactive")
    text = _("input {}: {}, stopped the machine {} times, {} glitches", name, state, trips, glitches)
    if int(at_ms):
        lasted = _("and still is") if lasted_ms == "-1" else _("for {:.3f} s", int(lasted_ms) / 1000)
        text += _("; last became active at {:.3f} s, {}", int(at_ms) / 1000, lasted)
    return text


def log_line_text(line):
    """Return a line of $LOG in words for people; None for any other."""
    name, colon, fields = line.strip("[]").partition(":")
    if name == "LOG":
        ms, number, who = fields.split(",", 2)
        return entry_text(int(ms), int(number), who)
    if name == "PIN":
        return pin_text(*fields.rsplit(",", 5))
    if name == "LOGGED":
        counts = [part.split("x") for part in fields.split(",") if part]
        return _("since the start: {}", ", ".join(_("{} times {}", count, number) for count, number in counts) or _("nothing"))
    return None
