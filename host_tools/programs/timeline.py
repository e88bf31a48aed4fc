"""A black box as people read it: its events, line by line, and a picture of them.

    lines_of(box)                       # lines of text
    draw_timeline(path, box, replay)             # PNG: lines, states, inputs, position and speed of each axis
"""

from host_tools.language import _, error_text
from host_tools.programs.blackbox import DROPPED, HALTED, INPUTS, LOGGED, ORDER, SAMPLE, STOOD
from passo import commands

_SPEED_MS = 20  # over which a speed is measured
_PAUSE_MS = 100  # without a step
_INCHES = 12, 10
_COLORS = {"alarm": "tab:red", "hold": "gold", "door": "gold", "idle": "0.7", "sleep": "0.7"}
_ROWS = 3  # of texts above the bars
_PAPER = {"facecolor": "white", "edgecolor": "none", "pad": 0.5}


def mm_text(board, position):
    """Return a position in steps as text in mm: `X12.500 Y3.000`."""
    return " ".join(f"{axis['name'].upper()}{1000 * at / axis['steps_per_m']:.3f}" for axis, at in zip(board["axes"], position))


def _event_texts():
    return {
        HALTED: _("stopped at once at {}"), DROPPED: _("stood at {}, the rest dropped"), STOOD: _("stood at {}, held"), SAMPLE: _("at {}"),
    }  # fmt: skip


def _order_texts():
    """Return {command of an order: its text for people}, in the language in force."""
    return {
        commands.HOLD: _("hold"), commands.RESUME: _("go on"), commands.DOOR: _("door, as an order"), commands.JOG_CANCEL: _("end of a jog"),
        commands.RESET: _("reset, Ctrl-X"), commands.STOP: _("stop, of another link"),
    }  # fmt: skip


def reason_text(box):
    """Return the event behind which the black box was written, for people."""
    return {
        "alarm": _("an alarm"), "end": _("the firmware ended: a crash, or the prompt was asked for"), "reset": _("a reset: the watchdog, or its button"),
    }.get(box.why, box.why)  # fmt: skip


def seconds_to_end(box, ms):
    """Return the seconds from the box's end to `ms`; negative: before it."""
    return (ms - box.end_ms) / 1000


def row_text(box, row, before):
    """Return the text of a row; `before`: inputs until then, {} at first."""
    if row.kind == INPUTS:
        changed = [f"{name} {_('on') if on else _('off')}" for name, on in row.levels.items() if on != before.get(name, False)]
        return ", ".join(changed) or _("inputs as at rest")
    if row.kind == LOGGED:
        return error_text(row.value)
    if row.kind == ORDER:
        return _order_texts().get(row.value, str(row.value))
    return _event_texts()[row.kind].format(mm_text(box.board, row.position)) + (f", {row.state}, {row.override} %" if row.kind == SAMPLE else "")


def lines_of(box):
    """Yield the text of each row, and of the program's lines that had come before it."""
    rows = sorted(box.rows + box.samples, key=lambda row: row.ms)
    come, levels = box.base, {}
    for row in rows:
        if row.come > come:
            text = box.text[come - box.base : row.come - box.base]
            yield "         > " + (text.decode("ascii", "backslashreplace").strip().replace("\r", "").replace("\n", " | ") if _is_plain(text) else text.hex(" "))
            come = row.come
        yield f"{seconds_to_end(box, row.ms):9.3f}  {row_text(box, row, levels)}"
        levels = row.levels or levels


def _is_plain(text):
    return all(byte in b"\r\n\t" or 32 <= byte < 127 for byte in text)


def speeds(rows, axis, per_mm):
    """Return ([ms], [mm/s]) of an axis, of a replay's rows (ms, *position, tool)."""
    times, values = [], []
    for first, last in _speed_spans(rows):
        span = rows[last][0] - rows[first][0]
        if span > 0:
            times.append((rows[first][0] + rows[last][0]) / 2)
            values.append((rows[last][1 + axis] - rows[first][1 + axis]) / per_mm / span * 1000)
    return times, values


def _speed_spans(rows):
    """Yield pairs of indices _SPEED_MS apart; a pause is a span of its own."""
    first = 0
    for last in range(1, len(rows)):
        if rows[last][0] - rows[first][0] >= _SPEED_MS:
            yield first, last
            first = last


def board_clock(box, replay):
    """As a function of ms of a replay, in arrays: the board's. The replay begins at the end of a queue that the board still had to play, and waits for
    no host: samples say when the board was where it is, and between two of them a pause takes what it is ahead."""
    import numpy

    seen, moves = {}, [row[0] for row in replay.rows]
    for ms, *place, _tool in replay.rows:
        seen.setdefault(tuple(place[: len(box.board["axes"])]), []).append(ms)
    pairs, ahead = [], 0
    for row in reversed(box.samples):
        found = seen.get(tuple(row.position))
        if found:
            ms = min(found, key=lambda ms: abs(row.ms - ms - ahead))
            if not pairs or ms < pairs[-1][0]:
                pairs.append((ms, row.ms))
                ahead = row.ms - ms
    if not pairs:
        return lambda ms: ms
    played, noted = numpy.array(pairs[::-1]).T
    pauses = [(at, until) for at, until in zip(moves, moves[1:]) if until - at > _PAUSE_MS]
    starts, ends = numpy.array(pauses).T if pauses else (numpy.zeros(0), numpy.zeros(0))
    before, behind = (numpy.clip(numpy.searchsorted(played, starts, "right") + by, 0, len(played) - 1) for by in (-1, 0))
    times = numpy.concatenate((played, starts, ends))
    shifts = numpy.concatenate((noted - played, (noted - played)[before], (noted - played)[behind]))
    order = numpy.argsort(times, kind="stable")
    times, shifts = times[order], shifts[order]
    return lambda ms: numpy.asarray(ms, float) + numpy.interp(ms, times, shifts)


def draw_timeline(path, box, replay=None):
    """Draw the timeline as a PNG: without a replay the positions alone; with one the path and speeds of each axis, at the board's times."""
    from host_tools.figures import pyplot

    axes = box.board["axes"]
    count = 1 + len(axes) + (len(axes) if replay else 0)
    plt = pyplot()
    figure, plots = plt.subplots(count, 1, sharex=True, figsize=_INCHES, layout="constrained", height_ratios=[3] + [2] * (count - 1))
    rows, states = [], [(row.ms, row.state) for row in box.samples]
    if replay:
        of = board_clock(box, replay)
        rows = [(ms, *row[1:]) for ms, row in zip(of([row[0] for row in replay.rows]).tolist(), replay.rows)]
        states = [(float(of(ms)), text) for ms, text in replay.events]
    _draw_events(plots[0], box, states)
    for number, axis in enumerate(axes):
        per_mm = axis["steps_per_m"] / 1000
        plot = plots[1 + number]
        if rows:
            plot.plot([seconds_to_end(box, row[0]) for row in rows], [row[1 + number] / per_mm for row in rows], linewidth=1, label=_("virtual board"))
        seen = [row for row in box.rows + box.samples if row.position]
        plot.plot([seconds_to_end(box, row.ms) for row in seen], [row.position[number] / per_mm for row in seen], "k.", markersize=4, label=_("the board"))
        plot.set_ylabel(_("{}, mm", axis["name"].upper()))
        if replay:
            times, values = speeds(rows, number, per_mm)
            plots[1 + len(axes) + number].plot([seconds_to_end(box, ms) for ms in times], values, linewidth=0.8, drawstyle="steps-mid")
            plots[1 + len(axes) + number].set_ylabel(_("{}, mm/s", axis["name"].upper()))
    stops = [seconds_to_end(box, row.ms) for row in box.rows if row.kind in (HALTED, DROPPED, STOOD)]
    for plot in plots:
        for number, at in enumerate(stops):
            plot.axvline(at, color="tab:red", linewidth=0.7, linestyle="--", label="" if number else _("stopped"))
    plots[1].legend(loc="best", fontsize=8)
    plots[-1].set_xlabel(_("s before the end of the black box"))
    first = seconds_to_end(box, min([row.ms for row in box.rows + box.samples], default=box.end_ms))
    plots[0].set_xlim(1.02 * first, max(-0.02 * first, 0.01))
    figure.suptitle(f"{box.board['name']}: {reason_text(box)}")
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _draw_events(plot, box, states):
    """Draw inputs and states as bars, lines and orders as ticks, numbers as text."""
    inputs = [row for row in box.rows if row.kind == INPUTS]
    names = sorted({name for row in inputs for name, on in row.levels.items() if on})
    first_ms = min([row.ms for row in box.rows + box.samples], default=0)
    labels = [_("bytes come"), _("state")] + names
    come = [(row.ms, row.come) for row in sorted(box.rows + box.samples, key=lambda row: row.ms)]
    for (ms, before), (until, behind) in zip(come, come[1:]):
        if behind > before:
            plot.barh(0, seconds_to_end(box, until) - seconds_to_end(box, ms), left=seconds_to_end(box, ms), height=0.6, color="tab:blue", alpha=0.6)
    states = [(ms, text) for ms, text in states if not text.isdigit() and ms < box.end_ms]
    for (ms, text), (until, _state) in zip(states, [*states[1:], (box.end_ms, "")]):
        plot.barh(1, max(until - ms, 0) / 1000, left=seconds_to_end(box, ms), height=0.6, color=_COLORS.get(text, "tab:green"), alpha=0.5)
        if until - ms > (box.end_ms - first_ms) / 40:
            plot.text(seconds_to_end(box, (ms + until) / 2), 1, text, ha="center", va="center", fontsize=8)
    for place, name in enumerate(names, 2):
        for row, until in zip(inputs, [*[row.ms for row in inputs[1:]], box.end_ms + 100]):
            if row.levels[name]:
                plot.barh(place, (until - row.ms) / 1000, left=seconds_to_end(box, row.ms), height=0.6, color="tab:orange")
    said = [row for row in box.rows if row.kind in (LOGGED, ORDER)]
    for count, row in enumerate(said):
        plot.axvline(seconds_to_end(box, row.ms), color="0.5", linewidth=0.6)
        height = len(labels) + 0.8 * (count % _ROWS)
        plot.text(seconds_to_end(box, row.ms), height, row_text(box, row, {}).split(":")[0] + " ", ha="right", va="center", fontsize=7, bbox=_PAPER)
    plot.set_yticks(range(len(labels)), labels)
    plot.set_ylim(-0.6, len(labels) + 0.8 * _ROWS)
