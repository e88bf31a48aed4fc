"""The interlock's part in the main loop: the work that the pins' interrupts leave to it. See port.py for theirs.

It lets a changed input allow again what it forbade, once it has lasted release_ms; notices changes whose edge was missed;
says why outputs went off; lets homing and probing come up to their sensors; switches on what the equations switch on by
themselves, if the board file asks for it; and keeps for each input when it last stopped something, and how long.
"""

from passo import commands, errors
from passo.commands import STATUS_WORDS
from passo.control.feature import Feature
from passo.options.interlock.steps_viper import INTERLOCK_OUTPUTS
from passo.records import COUNT_MASK

WORD = ("forbids", "Fb")  # inputs that forbid something now, in reports; an end of an axis with its direction: bxb(x+)


class InterlockWatch(Feature):
    def __init__(self, board, machine, queue):
        Feature.__init__(self, board, machine, queue)
        if WORD not in STATUS_WORDS:
            STATUS_WORDS.append(WORD)
        self._port = machine.port
        self._interlock = machine.veto
        self._levels = machine.inputs.levels
        section = board["interlock"]
        self._release_ms = section["release_ms"]
        self._unasked_ms = section["unasked_ms"]
        self._names = names = [item["name"] for item in board["inputs"]]
        ends = {name: end for end, name in section["limits"].items()}
        self._shown = [name + ("(%s)" % ends[name] if name in ends else "") for name in names]
        self._forbid = 0  # mask of those that `_told` names
        self._told = None
        self._outputs = [item["name"] for item in board["outputs"]]
        # Without these the motors do not follow.
        self._vital = [item["name"] for item in board["outputs"] if item["role"] == "ours" or item["name"][:6] == "enable"]
        self._halting = [item["name"] for item in board["inputs"] if item["halt"]]
        homing = board["homing"]
        sensors = list(homing["sensors"].values()) if homing else []
        sensors += [motor["sensor"] for motor in getattr(board.get("additions"), "more_motors", ())]
        # Inputs that forbid nothing while homing or probing looks for them.
        self._homes = sum([1 << number for number in range(len(names)) if names[number] in sensors])
        self._probes = sum([1 << number for number in range(len(names)) if names[number] == "probe"])
        self._seen = -1  # the pins at the last pass
        self._calm = False  # the interlock has them as they are
        self._raw = self._interlock.states
        self._since_ms = [0] * len(names)  # when each last became other than the interlock has it
        self._active_ms = [0] * len(names)  # when each last became active, as the interlock has it
        self._lasted_ms = [0] * len(names)  # how long it then was; −1: it still is
        self._states = self._interlock.states
        self._rest_ms = 0  # when machine and inputs came to rest
        machine.log.pins = self.pin_rows

    def ready(self):
        """Return True if words may be played: no input that halts is active. Asked before the first of them."""
        self._exempt_sensors()
        for name in self._halting:
            if self._port.input(name):
                return False
        return True

    def _exempt_sensors(self):
        """Let the sensors of a homing or a probing under way forbid nothing, and all others again."""
        machine = self._machine
        exempt = 0
        if machine.command is not None:
            if machine.command.kind == commands.HOME:
                exempt = self._homes
            elif machine.command.kind == commands.PROBE:
                exempt = self._probes
        self._interlock.exempt_inputs(exempt)

    def claim_stop(self, name):
        """Raise an alarm if an input of the interlock has stopped the player; limits and inputs that halt have one of their own."""
        if name not in self._names or self._interlock.has_own_alarm(name):
            return False
        self._machine.raise_alarm(errors.ALARM_INTERLOCK, name)
        return True

    def look(self, now_ms):
        """Do the main loop's part once a cycle: exempt sensors, changed inputs, lost outputs, outputs to switch on. See above."""
        interlock = self._interlock
        self._exempt_sensors()
        if interlock.states != self._states:
            self._note_changes(now_ms)
        seen = self._levels()
        if seen != self._seen or not self._calm:
            self._seen = seen
            self._compare_pins(now_ms)
        if interlock.states != self._states:
            self._note_changes(now_ms)
        if interlock.lost:
            self._report_lost()
        if self._unasked_ms:
            self._grant_unasked(now_ms)

    def _compare_pins(self, now_ms):
        """Compare the pins with the interlock's states, and take over differences that have lasted long enough."""
        interlock = self._interlock
        raw = interlock.read_pins()
        changed = raw ^ self._raw
        self._raw = raw
        differing = (raw ^ interlock.states) & interlock.watched
        self._calm = not differing
        number = 0
        while differing:
            if differing & 1:
                active = raw >> number & 1
                if changed >> number & 1:
                    self._since_ms[number] = now_ms
                forbids = (interlock.rise if active else interlock.fall) >> number & 1
                ms = interlock.filters_us[number] // 1000 + 1 if forbids else self._release_ms
                if (now_ms - self._since_ms[number]) & COUNT_MASK >= ms:
                    interlock.settle_input(number, active)
            differing >>= 1
            number += 1

    def _note_changes(self, now_ms):
        """Note when inputs have become active, and how long they were, by the interlock's states."""
        self._calm = False
        changed = self._interlock.states ^ self._states
        self._states ^= changed
        for number in range(len(self._names)):
            if changed >> number & 1:
                self._since_ms[number] = now_ms  # its effect holds for release_ms at least
                if self._states >> number & 1:
                    self._active_ms[number] = now_ms
                    self._lasted_ms[number] = -1
                else:
                    self._lasted_ms[number] = (now_ms - self._active_ms[number]) & COUNT_MASK
        self._rest_ms = now_ms

    def _report_lost(self):
        """Log the outputs that have been switched off, or were asked for in vain, with the input to blame. A vital one raises an alarm, and the
        position is lost."""
        machine = self._machine
        interlock = self._interlock
        lost = interlock.take_lost()
        for number in range(len(self._outputs)):
            bit = INTERLOCK_OUTPUTS << number
            if not lost & bit:
                continue
            blamed = interlock.blocking_input(bit, True)
            if self._outputs[number] in self._vital:
                machine.motors.release()
                if machine.alarm in errors.WATCHED:
                    machine.raise_alarm(errors.ALARM_INTERLOCK, blamed)
                machine.lose_position()
            else:
                machine.note(errors.INTERLOCKED, blamed)

    def _grant_unasked(self, now_ms):
        """Switch on the outputs that the equations switch on by themselves, once inputs and machine have been at rest for unasked_ms."""
        if not self._calm or not self._queue.still() or self._machine.alarm:
            self._rest_ms = now_ms
            return
        if (now_ms - self._rest_ms) & COUNT_MASK >= self._unasked_ms:
            mask = self._interlock.outputs_to_grant()
            if mask & ~self._interlock.granted:
                self._interlock.grant_outputs(mask)

    def report(self, report):
        """Add to a report: the glitches of the inputs, and the names of inputs that forbid outputs now (None: none)."""
        report["glitches"] = sum(self._interlock.glitches) or None
        interlock = self._interlock
        mask = interlock.states & interlock.rise | ~interlock.states & interlock.fall
        if mask != self._forbid:
            self._forbid = mask
            self._told = ",".join([self._shown[number] for number in range(len(self._shown)) if mask >> number & 1]) or None
        report["forbids"] = self._told

    def pin_rows(self):
        """Return [(name, active, how often it stopped the machine, glitches, ms when it last became active, ms it was active; −1: it still is)] of
        the inputs with any of these."""
        interlock = self._interlock
        found = []
        for number in range(len(self._names)):
            if interlock.watched >> number & 1 and (
                interlock.trips[number] or interlock.glitches[number] or self._active_ms[number]
            ):
                found.append((
                    self._names[number], interlock.states >> number & 1, interlock.trips[number], interlock.glitches[number],
                    self._active_ms[number], self._lasted_ms[number],
                ))  # fmt: skip
        return found
