"""`passo status`: how a board is now: state, positions, inputs, encoders, what it has logged."""

from host_tools.cli.log import BAUD, find_link, log_line_text
from host_tools.cli.options import AnyBaud, Port, Protocol
from host_tools.failure import Failure
from host_tools.language import N_, _, error_text
from passo import errors

_REPORTS = 40  # of grbl, until one has said what each says only now and then
_PINS = {
    "P": N_("probe"), "D": N_("door"), "H": N_("hold"), "R": N_("reset"), "S": N_("resume"), "N": N_("presence"),
    "n": N_("nobody at the machine"),
}  # fmt: skip
_MORE = {"RPM": N_("spindle, turns a minute"), "Gl": N_("glitches of inputs"), "Nh": N_("not homed")}
_ELSEWHERE = ("SD", "En", "Al")  # words of a status that have rows of their own
_ACCESSORIES = {"S": N_("spindle clockwise"), "C": N_("spindle counter-clockwise"), "F": N_("flood"), "M": N_("mist")}


def status(
    port: Port = None,
    baud: AnyBaud = None,
    protocol: Protocol = None,
):
    """Show state, position, inputs, encoders and the last errors and alarms. Moves and changes nothing, except that a
    plotter forgets its error once it is asked.

    A grbl link tells all of it, with the glitches of each input of an interlock and the following errors of encoders; the other
    languages tell what they have a word for.

    Example: passo status --port /dev/ttyACM0

    Example: passo status --port /dev/ttyUSB0 --protocol plotter
    """
    protocol, port, baud = find_link(port, baud, protocol)
    rows = {"grbl": _rows_of_grbl, "torch": _rows_of_torch, "pulses": _rows_of_pulses, "plotter": _rows_of_plotter}[protocol](port, baud)
    width = max(len(_(row[0])) for row in rows)
    for name, text in rows:
        print(f"{_(name):<{width}}  {text}".rstrip())


def _rows_of_grbl(port, baud):
    """Return the rows of a grbl link. Raises LinkError if it is gone."""
    from host_tools.clients.grbl import GrblClient
    from host_tools.clients.serial_port import LinkError

    with GrblClient(port, baud) as client:
        fields = {}
        for again in range(_REPORTS):
            fields = {**fields, **client.ask_status()}
            if "WCO" in fields and "Ov" in fields:
                break
        try:
            log = client.command("$LOG")
            job = _job_row(client, fields)
            # `En`: the board has some
            encoders = [line for line in client.command("$ENC") if line.startswith("[ENC:")] if "En" in fields else []
        except LinkError:
            fields = {**fields, **client.ask_status()}  # raises if the link is gone; else lines that were sent before hold the answers up
            return [*grbl_rows(fields, [], []), ("", _("no log, no encoders: they are answered after the lines sent before"))]
    rows = grbl_rows(fields, encoders, log)
    return rows[:1] + job + rows[1:]


def _job_row(client, fields):
    """Return the row of a job that has not been done to its end, in a list; [] if the board keeps no journal, or is not at rest."""
    from host_tools.clients.refusal import Refused
    from host_tools.programs import program_names, stored_job
    from host_tools.programs.job_record import Record

    if fields["state"] not in ("Idle", "Alarm"):
        return []
    try:
        options = "".join(line.split(",")[0] for line in client.command("$I") if line.startswith("[OPT:"))
        if "J" not in options:
            return []
        record = Record.of_answer(client.command("$JR"))
        if not record.job or not record.line:
            return []
        name, last = program_names.name_of_number(record.job)
        if not name and "F" in options:
            name = stored_job.name_by_crc(client.command("$F"), record.job)
    except Refused:
        return []  # something has begun meanwhile
    if name and record.done and record.line >= last:
        return []  # it has been done to its end
    name = name or _("a program that this PC has not begun ({})", f"{record.job:08x}")
    text = _("stopped after line {} of {}", record.line, name) if record.done else _("stopped amid line {} of {}", record.line, name)
    turns = _(", the spindle turns") if set("SC") & set(fields.get("A", "")) else _(", spindle off")
    goes_on = _("; passo engrave --continue goes on with it") if program_names.is_engraving(name) else _("; passo resume goes on with it")
    return [(N_("job"), text + turns + goes_on)]


def grbl_rows(fields, encoders, log):
    """Return [(name, text)] of the fields of status reports, the lines of $ENC and those of $LOG."""
    from host_tools import options
    from host_tools.clients.grbl_wire import FIELDS

    names = {**_MORE, **options.status_names()}
    rows = [(N_("state"), _state_text(fields, log))]
    offset = _parse_numbers(fields.get("WCO", ""))
    for name, key, other, sign in ((N_("machine"), "MPos", "WPos", 1), (N_("work"), "WPos", "MPos", -1)):
        position = _parse_numbers(fields.get(key, ""))
        if not position and key not in fields and offset and other in fields:
            position = [at + sign * by for at, by in zip(_parse_numbers(fields[other]), offset)]
        if position:
            rows.append((name, "  ".join(f"{axis} {at:.3f}" for axis, at in zip("XYZA", position))))
    feed, rpm = (*fields.get("FS", "0,0").split(","), "0")[:2]
    on = [_(_ACCESSORIES[letter]) for letter in fields.get("A", "") if letter in _ACCESSORIES]
    rows.append((N_("moves"), ", ".join([f"{feed} mm/min", f"S {rpm}", *on])))
    if "Ov" in fields:
        rows.append((N_("overrides"), _("feed {} %, rapids {} %, spindle {} %", *fields["Ov"].split(","))))
    active = [_(_PINS[letter]) if letter in _PINS else _("limit {}", letter) for letter in fields.get("Pn", "")]
    rows.append((N_("active"), ", ".join(active) or _("no input")))
    rows += [(_(names.get(word, word)), _word_text(word, fields)) for word in fields if word not in FIELDS + _ELSEWHERE]
    for line in encoders:
        motor, count, error, most = line[5:-1].split(",")
        rows.append((_("encoder {}", motor), _("{} counts, {} steps off, {} at most", count, error, most)))
    for text in map(log_line_text, log):
        if text:
            rows.append(("", text))
    return rows


def _state_text(fields, log):
    """Return the state; of an alarm with its number and meaning, from the report or else from the log."""
    state = fields["state"]
    if state.partition(":")[0] != "Alarm":
        return state
    logged = [int(line[5:-1].split(",")[1]) for line in log if line.startswith("[LOG:")]
    number = int(fields.get("Al", 0)) or next((number for number in reversed(logged) if number >= errors.ALARM_LOCKED), errors.ALARM_LOCKED)
    return f"{state} {number}: {error_text(number)}"


def _word_text(word, fields):
    """Return the text of a status word that an option adds."""
    if word == "Nh" and fields["state"].partition(":")[0] != "Alarm":
        return _("{}; soft limits ($20) do not hold", " ".join(fields[word]))
    if word in ("Vac", "Clamp"):
        return _("on") if fields[word].startswith("1") else _("off")
    if word == "Fb":
        return fields[word].replace("(", " (").replace(",", ", ")
    return " ".join(fields[word]) if word == "Nh" else fields[word]


def _parse_numbers(text):
    """Return the numbers of a text, separated by commas; [] of an empty one."""
    return [float(part) for part in text.split(",") if part]


def _rows_of_torch(port, baud):
    """Return the rows of a torch link, and its log. Raises Failure if the board has no word for its state."""
    from host_tools.cli.log import entry_lines
    from host_tools.clients.torch import TorchClient

    with TorchClient(port, baud) as client:
        fields, log = client.status(), client.log()
    if fields is None:
        raise Failure("{}: no answer, or a board that has no word for its state; is it one of --protocol {}?", port, ", ".join(BAUD))
    rows = [(name, str(value)) for name, value in fields.items()]
    return rows + [("", line) for line in entry_lines(log or [])]


def _rows_of_pulses(port, baud):
    """Return the rows of a pulses link, and its log. Raises Failure."""
    from host_tools.cli.log import entry_lines
    from host_tools.clients.pulses import PulsesClient

    with PulsesClient(port, baud) as client:
        fields, log = client.status(), client.log()
    return [(name, str(value)) for name, value in fields.items()] + [("", line) for line in entry_lines(log)]


def _rows_of_plotter(port, baud):
    """Return the rows of a plotter link's STATUS. Raises Failure."""
    from host_tools.clients.plotter import PlotterClient

    with PlotterClient(port, baud) as client:
        return [(name, str(value)) for name, value in client.status().items()]
