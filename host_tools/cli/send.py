"""`passo send`: sends packets from a terminal and shows their answers, in the format of the log of 2014."""

import re
import signal
import sys
import time
from pathlib import Path
from typing import Optional

import typer

from host_tools.cli.options import Baud, Port
from host_tools.failure import Failure
from host_tools.language import _, error_text

ARGUMENTS = {"LINE": 2, "MOVE": 2, "SPEED": 1, "LINK": 1}
OBJECT = "OBJECT"  # no packet: MOVE, LINE … and END of a polygon
_HEX = re.compile(r"[0-9a-fA-F]{2}$")
_POINT = re.compile(r"(\d{1,5}),(\d{1,5})$")


def send(
    words: Optional[list[str]] = typer.Argument(None, help="Packets by name with their numbers, or bytes in hex."),
    port: Port = None,
    baud: Baud = 57600,
    log: Optional[Path] = typer.Option(None, help="Save the conversation on the wire to this file."),
    timeout: float = typer.Option(3.0, min=0.1, help="Seconds an answer may take."),
):
    """Send packets to the plotter and show what it answers.

    Examples:

        passo send --port /dev/ttyACM0 REQUEST ORIGIN "SPEED 1000"
        passo send "MOVE 644 314" "LINE 644 454" "LINE 884 454" END STATUS
        passo send "OBJECT 644,314 644,454 884,454 884,314 644,314" "OBJECT 1000,100 1200,100"
        passo send 6d 02 84 01 3a 2e
        passo send

    OBJECT x,y x,y … is a polygon: MOVE to its first point, LINE to the others, END. Several are drawn in a row, each with its time.

    Names: REQUEST, LINE x y, MOVE x y, END, ORIGIN, SPEED n, UP, LEFT, DOWN, RIGHT, STOP, STATUS, LINK n. Bytes in
    hex are sent as they are. Without words, packets are read line by line.
    """
    from host_tools.cli import ports
    from host_tools.clients.plotter import PlotterClient

    items = parse_packets(words or [])
    with PlotterClient(port or ports.only_port(), baud, timeout, log) as client:
        before = signal.signal(signal.SIGINT, lambda *_: client.cancel())
        try:
            if words:
                drawn = [(item, _send_item(client, item)) for item in items]
                _print_objects([(item[1], seconds) for item, seconds in drawn if item[0] == OBJECT])
            else:
                signal.signal(signal.SIGINT, before)
                _send_from_keyboard(client)
        finally:
            signal.signal(signal.SIGINT, before)


def parse_packets(words):
    """Return [(name, numbers) | bytes] of words. Raises Failure at the first word that is neither."""
    from passo.protocols.plotter import host as plotter

    tokens = [token for word in words for token in word.split()]
    items = []
    while tokens:
        if _HEX.match(tokens[0]):
            run = []
            while tokens and _HEX.match(tokens[0]):
                run.append(int(tokens.pop(0), 16))
            items.append(bytes(run))
            continue
        name = tokens.pop(0).upper()
        if name == OBJECT:
            points = []
            while tokens and (point := _POINT.match(tokens[0])):
                points.append((int(point[1]), int(point[2])))
                tokens.pop(0)
            if len(points) < 2 or max(map(max, points)) > 65535:
                raise Failure("OBJECT wants two points or more, x,y from 0 to 65535 each, as in OBJECT 644,314 644,454")
            items.append((OBJECT, points))
            continue
        if name not in plotter.COMMANDS:
            raise Failure("{!r} is no packet; known are {}, or bytes in hex", name, ", ".join(sorted(plotter.COMMANDS)))
        count = ARGUMENTS.get(name, 0)
        numbers, tokens = tokens[:count], tokens[count:]
        if len(numbers) < count or not all(number.isdigit() and int(number) < 65536 for number in numbers):
            given = " ".join(numbers) or "-"
            if count == 1:
                raise Failure("{} wants a number from 0 to 65535, not {}", name, given)
            raise Failure("{} wants {} numbers from 0 to 65535, not {}", name, count, given)
        items.append((name, tuple(int(number) for number in numbers)))
    return items


def _send_from_keyboard(client):
    """Send packets from the keyboard (or a pipe) until its end; show errors and go on. Raises Failure at the end of a pipe if one failed."""
    tty = sys.stdin.isatty()
    failed = None
    while True:
        try:
            line = input("> " if tty else "")
        except (EOFError, KeyboardInterrupt):
            break
        try:
            for item in parse_packets([line.split("#")[0]]):
                _send_item(client, item)
        except Failure as failure:
            failed = failure
            print(failure.message(), file=sys.stderr)
    if failed and not tty:
        raise Failure("not every packet was carried out")


def _print_objects(drawn):
    """Print the times of the objects [(points, seconds)], if there are any."""
    for number, (points, seconds) in enumerate(drawn):
        print(_("Object {}: {} points, {:.3f} s", number, len(points), seconds))
    if len(drawn) > 1:
        print(_("{} objects: {:.3f} s", len(drawn), sum(seconds for _points, seconds in drawn)))


def _send_object(client, points):
    """Send a polygon's packets. Return the seconds from its first packet until it is drawn. Raises Failure."""
    begun = time.monotonic()
    for number, point in enumerate(points):
        _send_item(client, ("LINE" if number else "MOVE", point))
    _send_item(client, ("END", ()))
    return time.monotonic() - begun


def _send_item(client, item):
    """Send one item, and print it with its answer. Return the seconds of an object, else None. Raises Failure, also on Ctrl-C."""
    from host_tools.clients.plotter import Cancelled
    from host_tools.clients.wire import packet_text
    from passo.protocols.plotter import host as plotter

    if isinstance(item, bytes):
        _send_raw(client, item)
        return
    name, numbers = item
    if name == OBJECT:
        return _send_object(client, numbers)
    data = plotter.packet(plotter.COMMANDS[name], *numbers)
    print(_("Sending: {}", packet_text(data)), end="", flush=True)
    resends, begun = client.resends, time.monotonic()
    try:
        answer = _ACTIONS[name](client, *numbers)
    except Cancelled:
        client.stop()
        print("    " + _("stopped"))
        raise Failure("stopped by Ctrl-C: pen up, object dropped") from None
    except Failure:
        print("    " + _("Received: nothing"))
        raise
    took = time.monotonic() - begun
    again = "    " + _("(sent {} times more)", client.resends - resends) if client.resends > resends else ""
    print("    " + _("Received: {}", answer) + again)
    if name in ("END", "ORIGIN"):
        print(_("Time: {:.3f} s", took))


def _send_raw(client, data):
    """Send bytes as they are, and print all that comes back. Raises LinkError if nothing does."""
    from host_tools.clients.serial_port import LinkError
    from host_tools.clients.wire import answer_text, packet_text

    print(_("Sending: {}", packet_text(data)), end="", flush=True)
    events = client.send_raw(data)
    shown = []
    for kind, value in events:
        if kind == "answer":
            shown.append(answer_text(bytes([value])))
        else:
            shown.append(_status_text(value) if kind == "status" else _("torn {}", value.hex(" ")))
    print("    " + (_("Received: {}", ", ".join(shown)) if shown else _("Received: nothing")))
    if not shown:
        raise LinkError("no answer")


def _status_text(status):
    """Return a plotter's status, a dict, in one line for people."""
    fields = (status[name] for name in ("state", "x", "y", "drawn", "free"))
    error = _(", error {}: {}", status["error"], error_text(status["error"])) if status["error"] else ""
    return _("STATUS {} at {}, {}, {} points drawn, room for {}", *fields) + error


def _action(action, answer):
    """Return a function (client, numbers…) that calls `action` and returns the text of `answer`, the byte that ends it."""

    def act_and_answer(client, *numbers):
        """Call the action, and return its answer's text."""
        from host_tools.clients.wire import answer_text

        action(client, *numbers)
        return answer_text(answer)

    return act_and_answer


_ACTIONS = {
    "REQUEST": _action(lambda client: client.hello(), b"k"),
    "ORIGIN": _action(lambda client: client.origin(), b"o"),
    "SPEED": _action(lambda client, value: client.speed(value), b"s"),
    "LINK": _action(lambda client, number: client.hand_over(number), b"t"),
    "MOVE": _action(lambda client, x, y: client.point(False, x, y), b"n"),
    "LINE": _action(lambda client, x, y: client.point(True, x, y), b"n"),
    "END": _action(lambda client: client.end(), b"d"),
    "STOP": _action(lambda client: client.stop(), b"d"),
    "STATUS": lambda client: _status_text(client.status()),
}
for _name in ("UP", "LEFT", "DOWN", "RIGHT"):
    _ACTIONS[_name] = _action(lambda client, name=_name: client.jog(name), b"n")
