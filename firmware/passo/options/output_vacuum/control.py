"""M10 and M11: the output `vacuum`, a cleaner. Off in every safe state: stop, alarm, reset, sleep, M2, and while the door holds the machine.

Beside an output `clamp` these two codes are the clamp's; M64 P1 and M65 P1 switch a cleaner named p1_vacuum.
"""

from passo import commands
from passo.commands import STATUS_WORDS
from passo.control.feature import ANEW, OFF, SAFE
from passo.control.switched_output import SwitchedOutput

WORD = ("vacuum", "Vac")


class Vacuum(SwitchedOutput):
    event_mask = SAFE | OFF | ANEW

    def __init__(self, board, machine, queue):
        clamped = [item for item in board["outputs"] if item["name"].rpartition("_")[2] == "clamp"]
        SwitchedOutput.__init__(self, board, machine, queue, "vacuum", not clamped)
        if WORD not in STATUS_WORDS:
            STATUS_WORDS.append(WORD)

    def guard(self, handlers):
        """See the base; the handler of COOLANT switches the cleaner off at a program's end."""
        SwitchedOutput.guard(self, handlers)
        cool = handlers.get(commands.COOLANT)
        if cool:
            handlers[commands.COOLANT] = lambda command: self._end_coolant(command, cool)

    def _end_coolant(self, command, cool):
        """Do COOLANT by `cool`; switch the cleaner off if it ends a program."""
        result = cool(command)
        if not result and command.ends and self.on and not self._machine.checking:
            self.put(False)
        return result

    def report(self, report):
        report["vacuum"] = self.text()

    def show_outputs(self, on):
        """Switch the cleaner off for an open door, and on again."""
        if self.on:
            self._machine.port.output(self._name, on)

    def on_events(self, _=SAFE):
        """Switch the cleaner off."""
        self.put(False)

    halt = on_events
