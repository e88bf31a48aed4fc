"""The watchdog of the links: a host that says nothing for too long, while what it has asked for is under way, is lost.

Per link of the board file: `lost`, what is done then, and `lost_ms`. Under way is what the link that commands has begun: motion,
but for homing, or a tool or spindle that is on. What says something on a framed link is a sound frame, not noise.
"""

from passo import commands, errors
from passo.records import COUNT_MASK


class WatchedLine:
    """A serial line that notes whether bytes have come."""

    def __init__(self, serial):
        self._serial = serial
        self.heard = False  # it is the reader's to clear
        self.write = serial.write
        self.any = getattr(serial, "any", None)  # lines of the virtual port have none

    def read(self):
        data = self._serial.read()
        if data:
            self.heard = True
        return data

    def close(self):
        self._serial.close()


class HostWatch:
    def __init__(self, board, machine, queue):
        self._machine = machine
        self._queue = queue
        self._links = board["links"]
        self._lines = {}  # by the numbers of their links; stored jobs come by another, and need no host
        self._since_ms = 0  # nothing has come from the link that commands, or nothing was under way

    def watch(self, number, line):
        """Returns what is to be read instead of `line`, that of link `number`."""
        if not hasattr(line, "heard"):
            line = WatchedLine(line)
        self._lines[number] = line
        return line

    def poll(self, _):
        """By the links' clock: in fast virtual time the machine's runs ahead of any host."""
        machine = self._machine
        now_ms = machine.port.link_ms()
        number = machine.commander
        line = self._lines.get(number)
        if line is None:
            return
        if line.heard or not self._under_way():
            line.heard = False
            self._since_ms = now_ms
            return
        link = self._links[number]
        if (now_ms - self._since_ms) & COUNT_MASK >= link["lost_ms"]:
            self._since_ms = now_ms
            self._lost(link)

    def _under_way(self):
        machine = self._machine
        if machine.unattended:
            return False
        state = machine.state
        return state == "run" or state == "jog" or state == "idle" and (self._queue.lit() or machine.spindle != commands.SPINDLE_OFF)

    def _lost(self, link):
        machine = self._machine
        if commands.HOLD not in machine.handlers:
            machine.note(errors.HOST_LOST, link["name"])
            machine.carry_out(commands.STOP)
        elif link["lost"] == "stop":
            machine.raise_alarm(errors.ALARM_HOST_LOST, link["name"])
        else:
            machine.note(errors.HOST_LOST, link["name"])
            machine.carry_out(commands.HOLD)
