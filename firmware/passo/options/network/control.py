"""Admission of motion over the network without a key: a person at the machine admits it, for some minutes.

ADMIT on any cable says for how long, 0 ends it; or the input that the board file names in network.button, for network.minutes. It
ends by itself, with a reset of the board, and with an alarm.

If the board file names network.presence, spindle on, resume and a stored job over the network are refused while that input is not active. It
shows behind the letters of the inputs: N somebody is there, n nobody, for the page of a PC that serves a network beside a cable.
"""

from micropython import const

from passo import commands, errors
from passo.control.feature import Feature
from passo.control.links import ANY_LINK, RIGHTS, STARTS
from passo.records import COUNT_MASK, NETWORK_PORTS

_MINUTE_MS = const(60_000)
_MOST_MINUTES = const(60)


def _starts_work(command):
    """Return True for a command that starts the tool or a program: somebody has to be at the machine."""
    if command.kind == commands.SPINDLE:
        return command.value != commands.SPINDLE_OFF
    return not command.value


class Admission(Feature):
    def __init__(self, board, machine, queue):
        config = board["network"]
        Feature.__init__(self, board, machine, queue)
        self._networked = [number for number, link in enumerate(board["links"]) if link["port"] in NETWORK_PORTS]
        self._legacy = config["legacy_http"]
        self._button = config["button"]
        self._minutes = config["minutes"]
        self._presence = machine.presence = config["presence"]
        self._pressed = True  # one that is held at the start admits nobody
        self._since_ms = 0
        self._length_ms = 0

    def handlers(self):
        RIGHTS[commands.ADMIT] = ANY_LINK
        return {commands.ADMIT: self._do_admit}

    def guard(self, handlers):
        """Wrap the handlers that need somebody at the machine."""
        if self._presence:
            for kind in handlers:
                if kind == commands.SPINDLE or RIGHTS.get(kind, 0) & STARTS:
                    handlers[kind] = self._with_presence(handlers[kind])

    def _with_presence(self, handler):
        """Return `handler`, which over the network refuses such a command while the presence input is not active."""

        def handle_if_present(command):
            """Do the command, or return PRESENCE."""
            link = command.link
            if link is not None and link.number in self._networked and _starts_work(command) and not self._machine.port.input(self._presence):
                return errors.PRESENCE
            return handler(command)

        return handle_if_present

    def is_admitted(self):
        """Return True while commands without a key are admitted."""
        return self._length_ms > 0

    def look(self, now_ms):
        """Admit for network.minutes as the button is pressed; end the admission when its time is over, and in an alarm."""
        if self._button:
            pressed = self._machine.port.input(self._button)
            if pressed and not self._pressed and not self._machine.alarm:
                self._admit_for(self._minutes)
            self._pressed = pressed
        if self._length_ms and ((now_ms - self._since_ms) & COUNT_MASK >= self._length_ms or self._machine.alarm):
            self._length_ms = 0

    def _admit_for(self, minutes):
        """x; 0 ends it."""
        self._since_ms = self._machine.port.machine_ms()
        self._length_ms = minutes * _MINUTE_MS

    def _do_admit(self, command):
        """Do ADMIT, of a cable only. Returns the number of an error, or 0."""
        if not self._legacy or command.link is not None and command.link.number in self._networked:
            return errors.NOT_ADMITTED
        if not 0 <= command.value <= _MOST_MINUTES:
            return errors.SETTING_RANGE
        self._admit_for(command.value)
        return self._machine.confirm_command(command)
