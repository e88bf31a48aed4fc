"""A stop, a reset and an alarm go through the features once: each hears of it once, however it began."""

from passo import commands, errors
from passo.control.feature import Feature
from router import Machine

EVENTS = ("halt", "clear", "release", "switch_off", "restart", "dropped")
ONCE = {
    "reset": (1, 1, 1, 1, 1, 0),
    "reset at rest": (1, 1, 0, 0, 1, 0),
    "stop": (1, 1, 0, 0, 0, 0),
    "hard limit": (1, 1, 1, 1, 0, 0),
    "soft limit": (0, 1, 0, 1, 0, 1),
}


class Counter(Feature):
    def __init__(self):
        self.heard = [0] * len(EVENTS)
        for number in range(len(EVENTS)):
            setattr(self, EVENTS[number], self._counted(number))

    def _counted(self, number):
        def count():
            self.heard[number] += 1

        return count


def heard(event):
    machine = Machine().ready()
    if event != "reset at rest":
        machine.put("G91 G1 X50 F1000\n")
        machine.cycles(60)
    counter = Counter()
    record = machine.controller.machine
    record._features.append(counter)
    if event == "stop":
        record.carry_out(commands.STOP)
    elif event == "hard limit":
        record.raise_alarm(errors.ALARM_HARD_LIMIT)
    elif event == "soft limit":
        record.raise_alarm(errors.ALARM_SOFT_LIMIT)
    else:
        machine.put("\x18")
    machine.settle()
    return tuple(counter.heard)


def check_each_event_once():
    for event in ONCE:
        assert heard(event) == ONCE[event], (event, heard(event))
