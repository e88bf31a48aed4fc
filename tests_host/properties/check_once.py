"""A stop, a reset and an alarm go through the features once: each hears of it once, however it began."""

from passo import commands, errors
from passo.control.feature import ANEW, OFF, QUEUE_GONE, SAFE, WORK_GONE, Feature
from router import Machine

ONCE = {  # how often the pins have stopped, and the masks of events that a feature got
    "reset": (1, [WORK_GONE | SAFE | OFF | ANEW]),
    "reset at rest": (1, [WORK_GONE | ANEW]),
    "stop": (1, [WORK_GONE]),
    "hard limit": (1, [WORK_GONE | SAFE | OFF]),
    "soft limit": (0, [WORK_GONE, QUEUE_GONE, OFF]),
}


class Counter(Feature):
    event_mask = -1

    def __init__(self):
        self.heard = []
        self.halts = 0

    def halt(self):
        self.halts += 1

    def on_events(self, what):
        self.heard.append(what)


def heard(event):
    machine = Machine().ready()
    if event != "reset at rest":
        machine.put("G91 G1 X50 F1000\n")
        machine.cycles(60)
    counter = Counter()
    record = machine.controller.machine
    record._features.append(counter)
    record._halts += (counter.halt,)
    if event == "stop":
        record.carry_out(commands.STOP)
    elif event == "hard limit":
        record.raise_alarm(errors.ALARM_HARD_LIMIT)
    elif event == "soft limit":
        record.raise_alarm(errors.ALARM_SOFT_LIMIT)
    else:
        machine.put("\x18")
    machine.settle()
    return counter.halts, counter.heard


def check_each_event_once():
    for event in ONCE:
        assert heard(event) == ONCE[event], (event, heard(event))
