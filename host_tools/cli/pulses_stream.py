"""Plays a pulse file that is longer than a board's memory: from any command, backward, and repeated, streamed by this PC.

The board remembers the last commands of the stream and goes back through them by itself. At the oldest one it is stopped, and gets the
rest of the way back as a new stream.
"""

from host_tools.cli.pulses_panel import Panel, status_text
from host_tools.clients.refusal import Refused
from host_tools.failure import Failure
from host_tools.language import _
from host_tools.programs.job_record import BACK, DONE
from passo import errors
from passo.protocols.pulses.errors import NO_CONTROL

_JOG = 999_999  # steps in one order


class _Oldest(Exception):
    """The board has gone back as far as it remembers."""


def play_long(client, file, number=0, backward=False, times=1, speed=None, show=None):
    """Play a LongFile from command `number`, where the head stands before it; return the last status. `speed`: mm/min, None: the file's. Calls
    `show(panel, status)` each cycle. Raises Failure."""
    from host_tools.clients.pulses import check

    if speed:
        client.command("speed", speed)
    while True:
        announce_stream(client, file, number, backward, times)
        chunks = file.play_backward(number) if backward else file.play_forward(number, times)
        lead = file.lead_of(number, backward)
        with Panel(client) as panel:

            def poll_panel():
                """Poll keys while bytes go out. Raises _Oldest once the board is back at the oldest command that it remembers."""
                if "oldest" in client.said:
                    raise _Oldest
                panel.poll_keys()
                if show:
                    show(panel, client.status())

            try:
                client.send_file(chunks, True, idle=poll_panel)
                status = panel.follow_run(True)
                if "oldest" not in client.said:
                    for line in client.said:
                        check(line, _("the run"))
                    return status
            except _Oldest:
                pass
        status = client.status()
        client.said = [line for line in client.said if line != "oldest"]
        done = max(int(status["at"]) - lead, 0)
        number = max(number - done, 0) if backward else (number + done) % file.total
        if not number and not backward:
            return status
        client.command("stop")
        backward, times = not backward, 1


def announce_stream(client, file, number=0, backward=False, times=1):
    """Tell a board with a journal which stream begins: the rest of a LongFile from command `number`."""
    flags = DONE | (BACK if backward else 0) | min(times, 255) << 8
    tell_journal(client, f"$JR={file.job_number():08x},{number},{flags},{file.lead_of(number, backward)}")


def tell_journal(client, line):
    """Send a `$JR` line; ignore the refusal of a board without a journal. Raises Refused for other errors."""
    try:
        client.ask(line)
    except Refused as refused:
        if refused.number not in (errors.STATEMENT, NO_CONTROL):
            raise


def jog_to(client, file, number):
    """Move by hand, tool off, from the start of the file to the position at which command `number` begins. Raises Failure."""
    jog_by(client, file.seek(number).place)


def jog_by(client, way):
    """Move by hand, tool off, by `way`: steps of each axis, one axis after the other. Raises Failure if a move does not end."""
    place = list(way)
    while any(place):
        words = ["jog"]
        for axis, steps in enumerate(place):
            part = max(-_JOG, min(steps, _JOG))
            if part:
                words += ["xyz"[axis], part]
                place[axis] -= part
        client.command(*words)
        with Panel(client) as panel:
            status = panel.follow_run(False)
        if status["state"] not in ("idle", "hold"):
            raise Failure("not there yet: {}", status_text(status))
