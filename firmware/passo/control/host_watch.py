"""The watchdog of the links: a host that says nothing for too long, while what it has asked for is under way, is lost.

Per link of the board file: `lost`, what is done then, and `lost_ms`. Under way is what the link that commands has begun: motion,
but for homing, or a tool or spindle that is on. On a framed link a sound frame counts as a word of the host, noise does not.

Some senders of G-code say nothing while a line lasts. So one of grbl counts as lost only if it asks for the status by habit: at least once
in every lost_ms, from the beginning of the work until it falls silent. If it has left out one such time, it must first ask in time for
three of them: a program that only looks in, with a few questions at once, is no host. Nor does it count if it asks so seldom as grbl's
stream.py, once a second: that falls silent with the answer to its last line, while the machine still moves. In other languages any silent
host is lost.

"retract": as "stop", but before tool and outputs go off Z goes up to where it stood after homing, if it has homed at its high end.
"""

from micropython import const

from passo import commands, errors
from passo.config import setting_numbers as table
from passo.control.feature import OFF, WORK_GONE, Feature
from passo.records import COUNT_MASK

_SURE = const(3)  # times lost_ms
_SELDOM_MS = const(800)  # between two questions
_MAY_BE_SILENT = "grbl"  # the language
_Z = const(2)


class HostWatch(Feature):
    def __init__(self, board, machine, queue):
        Feature.__init__(self, board, machine, queue)
        self._links = board["links"]
        self._lines = {}  # the lines, by the numbers of their links; stored jobs come by another, and need no host
        self._since_ms = 0  # the last bytes of the link that commands, or the last moment without work
        self._works = False  # something is under way
        self._asks = False  # the host of the link that commands has asked
        self._asked_ms = 0  # the time of its last question, or of the beginning of the work
        self._doubt = -1  # since when it asks in time again, because it has let lost_ms pass without a question; −1: it has not, or for long
        self._question_ms = 0  # of its last question
        self._seldom = 0  # questions that came _SELDOM_MS or more behind the one before, the last ones in a row
        self._number = -1  # the link that commands
        homing = board["homing"]
        names = [axis["name"] for axis in board["axes"]]
        self._rises = bool(homing) and "z" in homing["high_end"] and names[_Z : _Z + 1] == ["z"]
        self._silent = False  # for lost_ms, as the last cycle found
        self._retracts = False  # lost: once it stands, Z goes up before the tool goes off
        self._up = False  # it does
        self._power = 0  # of the tool, as it was

    def watch(self, number, line):
        """`line.was_heard()` tells whether link `number` has heard anything: its Link, or the line of a framed one."""
        self._lines[number] = line

    def poll(self, _):
        """Notice whether work is under way, and watch its host by the links' clock: in fast virtual time the machine's runs ahead of any host."""
        machine = self._machine
        number = machine.commander
        line = self._lines.get(number)
        worked = self._works
        state = machine.state
        self._works = line is not None and (
            state == "run" or state == "jog" or state == "idle" and (self._queue.lit() or machine.spindle != commands.SPINDLE_OFF)
        )
        if self._retracts:
            self._go_up()
        if line is None:
            return
        if number != self._number:
            self._asks = False
            self._number = number
        if self._works:
            machine.awake = True
            self._check_host(line, worked)

    def _check_host(self, line, worked):
        """Act if the host of the link that commands is lost. `line`: its line; `worked`: its work was already under way in the last cycle."""
        now_ms = self._machine.port.link_ms()
        if not worked:
            self._asked_ms = now_ms
            self._doubt = -1
        if line.was_heard() or not worked:
            self._since_ms = now_ms
            self._silent = False
            return
        link = self._links[self._number]
        if (now_ms - self._since_ms) & COUNT_MASK >= link["lost_ms"]:
            if not self._silent:  # the links are read once more: this board itself may have stood still, and bytes that came then wait
                self._silent = True
                return
            self._silent = False
            in_time = (self._since_ms - self._asked_ms) & COUNT_MASK < link["lost_ms"]
            if link["protocol"] != _MAY_BE_SILENT or self._asks and self._doubt < 0 and self._seldom < 2 and in_time:
                self._act_on_loss(link)
            self._since_ms = now_ms

    def report(self, report):
        """Note that the host of report["link"] has asked for the status, in time or late."""
        link = report["link"]
        if link is None or link.number != self._number or link.number not in self._lines:
            return
        now_ms = self._machine.port.link_ms()
        lost_ms = self._links[self._number]["lost_ms"]
        if (now_ms - self._asked_ms) & COUNT_MASK >= lost_ms:
            self._doubt = now_ms
        elif self._doubt >= 0 and (now_ms - self._doubt) & COUNT_MASK >= _SURE * lost_ms:
            self._doubt = -1
        self._asks = True
        self._seldom = 0 if (now_ms - self._question_ms) & COUNT_MASK < _SELDOM_MS else self._seldom + 1
        self._asked_ms = self._question_ms = now_ms

    def _act_on_loss(self, link):
        """Do what the board file says of a lost host: hold, stop, or alarm HOST_LOST, with "retract" before Z goes up."""
        machine = self._machine
        if commands.HOLD not in machine.handlers:
            machine.note(errors.HOST_LOST, link["name"])
            machine.carry_out(commands.STOP)
        elif link["lost"] != "pause":
            self._power = self._queue.planner.power
            machine.raise_alarm(errors.ALARM_HOST_LOST, link["name"])
            rises = self._rises and machine.homed and not machine.settings.value(table.LASER)
            if rises and link["lost"] == "retract":
                self._retracts = machine.retracts = True
                self.event_mask = WORK_GONE  # else there is nothing to end
        else:
            machine.note(errors.HOST_LOST, link["name"])
            machine.carry_out(commands.HOLD)

    def _go_up(self):
        """Once the machine stands, move Z up to 0, then switch tool and outputs off."""
        machine = self._machine
        queue = self._queue
        machine.awake = True
        if machine.dropping or not queue.still():
            return
        target = list(queue.position())
        if not self._up and target[_Z] < 0:
            self._up = True
            target[_Z] = 0
            queue.tool = queue.lit()
            queue.planner.set_power(self._power, False)
            queue.go(target, 0, 0, queue.tool, 0)
            queue.flush()
        else:
            self.on_events()

    def on_events(self, _=WORK_GONE):
        """End the retract: Z is up, or all work is dropped. Tool and outputs go off."""
        self.event_mask = 0
        self._retracts = self._up = self._machine.retracts = False
        self._machine.inform(OFF)
