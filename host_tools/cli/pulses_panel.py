"""The status line and the keys while a file of pulse codes is played.

    with Panel(client) as panel:
        client.send_file(data, stream=True, idle=panel.poll_keys)
        status = panel.follow_run(playing=True)

This program has the port until the end, so pause, speed and stop come from its own keys.
"""

import contextlib
import os
import select
import sys
import time

from host_tools.failure import Failure
from host_tools.language import _

_COMMANDS = {"p": "pause", "r": "run", "b": "back"}
_SHOW_S = 0.25


def status_text(status):
    """Return a status, {field: text}, in one line for people."""
    parts = [_("{:<5} command {} of {}", status["state"], status["at"], status["of"])]
    if status["pass"] != "1/1":
        parts.append(_("pass {}", status["pass"]))
    speed = status["speed"]
    parts.append(_("backward at {} mm/min", speed) if status["going"] == "-" else _("forward at {} mm/min", speed))
    if status["wait"] != "0":
        parts.append(_("waits {:.1f} s", int(status["wait"]) / 1000))
    if status["ask"] == "1":
        parts.append(_("WAITS FOR A SPEED"))
    if status["manual"] != "0":
        parts.append(_("{} steps by hand", status["manual"]))
    parts.append(_("place {}", status["place"]))
    parts.append(_("tool on") if status["tool"] == "1" else _("tool off"))
    parts.append(_("port {}", status["port"]))
    return ", ".join(parts)


class Panel:
    """Keys are read if standard input is a terminal."""

    def __init__(self, client):
        self._client = client
        self._terminal = sys.stdin.isatty()
        self._stack = contextlib.ExitStack()
        self._typed = ""  # digits of a speed
        self._said = ""  # why the last key was refused
        self._shown = 0.0

    def __enter__(self):
        if self._terminal:
            import termios
            import tty

            before = termios.tcgetattr(sys.stdin)
            self._stack.callback(termios.tcsetattr, sys.stdin, termios.TCSADRAIN, before)
            tty.setcbreak(sys.stdin)
        return self

    def __exit__(self, *_):
        self._stack.close()
        if sys.stderr.isatty():
            print("\r\x1b[K", end="", file=sys.stderr)

    def poll_keys(self):
        """Handle a key, if one was pressed; redraw the screen four times a second. Raises Stopped after s, LinkError if the port is lost."""
        if self._terminal and select.select([sys.stdin], [], [], 0)[0]:
            self._press_key(os.read(sys.stdin.fileno(), 1).decode("ascii", "replace"))
        if sys.stderr.isatty() and time.monotonic() - self._shown > _SHOW_S:
            self._show_status(self._client.status())

    def follow_run(self, playing):
        """Wait until the machine is at rest; return the last status. If it is `playing` and there are keys to end a pause, a pause is no end. Raises
        as poll_keys()."""
        from host_tools.clients.pulses import POLL_S

        while True:
            status = self._client.status()
            self._show_status(status)
            paused = status["state"] == "hold" and playing and self._terminal
            if status["state"] != "run" and not paused:
                return status
            self.poll_keys()
            time.sleep(POLL_S)

    def _press_key(self, key):
        """Send the order of a key, or gather digits of a speed. Raises Stopped after s, LinkError; note a refusal for the screen."""
        from host_tools.clients.serial_port import LinkError

        self._said = ""
        try:
            if key in _COMMANDS:
                self._client.command(_COMMANDS[key])
            elif key == "s":
                self._client.command("stop")
                raise Stopped("stopped at {}", status_text(self._client.status()))
            elif key.isdigit():
                self._typed += key
            elif key in "\r\n" and self._typed:
                self._client.command("speed", self._typed)
                self._typed = ""
            elif key in "\x7f\b":
                self._typed = self._typed[:-1]
        except (LinkError, Stopped):
            raise
        except Failure as refused:
            self._typed, self._said = "", refused.message()

    def _show_status(self, status):
        """Show a status and the keys in one line on stderr, if it is a terminal."""
        if not sys.stderr.isatty():
            return
        self._shown = time.monotonic()
        text = status_text(status)
        if self._terminal:
            keys = _("r go on") if status["state"] == "hold" else _("p pause")
            text += "  " + _("({}, b back, s stop, a number and Enter: mm/min)", keys) + f" {self._typed}{self._said}"
        print("\r\x1b[K" + text, end="", file=sys.stderr, flush=True)


class Stopped(Failure):
    """The operator stopped the run."""
