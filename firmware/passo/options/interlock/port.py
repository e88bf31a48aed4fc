"""The interlock at the pins, shared by all ports: the active inputs, the motion and outputs that they forbid, and the stop.

    port.veto.take_change(number, active)  # from an interrupt: an input has changed, and has lasted its filter's time
    port.veto.denied                       # mask of INTERLOCK_…, now

Subclasses, for chips and for the virtual port, bring it changes, and have now(), lit() and put(mask, on).

A change that forbids acts at once, in the interrupt: outputs that are no longer allowed go off, and stay off until they are asked
for anew; the player is halted if a step that is forbidden lies ahead, or the tool is on. Words made later are looked at before
they are handed to the player: none that steps towards an active limit is ever played. While nothing is forbidden that costs one
comparison a cycle of the feeder.
"""

from array import array

import micropython

from passo.options.interlock.steps_viper import (
    INTERLOCK_OUTPUTS, INTERLOCK_TOOL, PERMIT_ALLOWS, PERMIT_CARE, PERMIT_FIELDS, PERMIT_FIRST, PERMIT_GATED,
    PERMIT_VALUE, find_ahead, find_denied,
)  # fmt: skip


class Interlock:
    """Has no pins: see port_pins.py and port_virtual.py."""

    def __init__(self, board, port):
        compiled = board["additions"].masks
        self._port = port
        self.table = array("i", compiled["table"])
        self._unasked = array("i", compiled["unasked"])
        self._limits = compiled["limits"]
        for number in range(len(board["inputs"])):
            self._limits |= board["inputs"][number]["halt"] << number
        self.rise, self.fall = compiled["rise"], compiled["fall"]  # inputs whose becoming active, or inactive, may forbid
        self.watched = self.rise | self.fall
        self._names = [item["name"] for item in board["inputs"]]
        self._outputs = [item["name"] for item in board["outputs"]]
        self.filters_us = [item["filter_us"] for item in board["inputs"]]
        self.states = 0  # of the inputs, a bit each: 1 active
        self.exempt = 0  # inputs that forbid nothing just now: homing looks for them
        self.denied = 0
        self.asked = 0  # outputs that the board has switched on
        self.granted = 0  # and those that are on though it has not: see grant_outputs()
        self.lost = 0  # outputs that were switched off: see take_lost()
        self.glitches = array("i", [0] * len(self._names))  # changes of each input that did not last
        self.trips = array("i", [0] * len(self._names))
        self._lost_states = 0  # the inputs when the last was
        self._wrong = self._wrong_states = 0  # of the last halt: the forbidden mask, and the inputs then
        self._player = self._state = self._segments = self._start = self._played = None  # see join()
        self.items = ()  # the port's inputs, in the board file's order
        self.playing = None  # reads the words made, and stops them: all at once, for an interrupt that has no time to look

    def join(self, feeder, player):
        """Play nothing that is forbidden from here on. Called once, before anything is played."""
        self._state = feeder.state
        self._segments = feeder.marks
        self._player = player
        self._start = player.start
        self._played = player.words_played
        self.playing = feeder.state, feeder.marks, player.words_played, player.halt, getattr(player, "hold", None)
        player.start = self.start

    # --- interrupts

    @micropython.native
    def start(self):  # ISR: no allocation
        """Start the player, unless its words are forbidden: then stop it."""
        forbidden = self.denied
        if forbidden and find_ahead(self._state, self._segments, self._played(), forbidden):
            self._trip()
            return False
        return self._start()

    @micropython.native
    def take_change(self, number, active):  # ISR: no allocation
        """Take over that input `number` is `active`, and has been for its filter's time."""
        if active:
            self.states |= 1 << number
        else:
            self.states &= ~(1 << number)
        self.update_denied()

    @micropython.native
    def update_denied(self):  # ISR: no allocation
        """Update the forbidden bits; switch off outputs that are not allowed any more, and stop the player if a forbidden step lies ahead."""
        exempt = self.exempt
        forbidden = find_denied(self.table, self.states & ~exempt | self.fall & exempt)
        self.denied = forbidden
        if self.granted:
            gone = self.granted & find_denied(self._unasked, self.states)
            if gone:
                self.granted &= ~gone
                self.put_outputs(gone & ~self.asked, 0)
        if not forbidden:
            return
        lost = forbidden & (self.asked | self.granted)
        if lost:
            self.asked &= ~lost
            self.granted &= ~lost
            self.lost |= lost
            self._lost_states = self.states
            self.put_outputs(lost, 0)
        if self._player is not None and (
            find_ahead(self._state, self._segments, self._played(), forbidden & ~INTERLOCK_TOOL)
            or forbidden & INTERLOCK_TOOL and self.is_tool_on()
        ):
            self._trip()

    @micropython.native
    def _trip(self):  # ISR: no allocation
        """Tell the port that the interlock has stopped the player, and why."""
        self._wrong = find_ahead(self._state, self._segments, self._played(), self.denied) or self.denied & INTERLOCK_TOOL
        self._wrong_states = self.states
        self._port.trip(self)

    @micropython.native
    def note_halt(self, item):  # ISR: no allocation
        """Take over a halting input, one of `items`, that has stopped the player already."""
        number = 0
        while self.items[number] is not item:
            number += 1
        if not self.states >> number & 1:  # it may bounce
            self.trips[number] += 1
        self.states |= 1 << number
        forbidden = find_denied(self.table, self.states & ~self.exempt | self.fall & self.exempt)
        self.denied = forbidden
        lost = forbidden & (self.asked | self.granted)
        self.asked &= ~lost
        self.granted &= ~lost
        self.lost |= lost
        self._lost_states = self.states
        self.put_outputs(lost, 0)

    # --- main loop: it writes the interrupts' fields with the interrupts locked

    def lock(self):
        """Lock out interrupts until unlock() of the value returned."""

    def unlock(self, state):
        """Let interrupts come again; `state`: the value of lock()."""

    def settle_input(self, number, active):
        """Call take_change() from the main loop, with the interrupts locked out."""
        state = self.lock()
        self.take_change(number, active)
        self.unlock(state)

    @property
    def name(self):
        """Name of the input that the last halt was for. Reading it counts the halt."""
        number = self.input_to_blame(self._wrong, self._wrong_states)
        self.trips[number] += 1
        return self._names[number]

    def input_to_blame(self, wrong, states):
        """Return the number of the input to blame for the forbidden bits `wrong`: of the product that wants the fewest changes, the first."""
        table = self.table
        best, number = 99, 0
        for at in range(PERMIT_FIRST, len(table), PERMIT_FIELDS):
            if table[at + PERMIT_ALLOWS] & wrong:
                against = (states ^ table[at + PERMIT_VALUE]) & table[at + PERMIT_CARE]
                found = [each for each in range(len(self._names)) if against >> each & 1]
                if 0 < len(found) < best:
                    best, number = len(found), found[0]
        return number

    def blocking_input(self, wrong, lost=False):
        """Return the name of the input that forbids `wrong` now; `lost`: of the one that forbade it when an output was lost."""
        return self._names[self.input_to_blame(wrong, self._lost_states if lost else self.states)]

    def has_own_alarm(self, name):
        """True for a limit and an input that halts, which have an alarm of their own."""
        return bool(self._limits >> self._names.index(name) & 1)

    def exempt_inputs(self, inputs):
        """Let the inputs of a mask forbid nothing from now on, and all others again."""
        if inputs != self.exempt:
            state = self.lock()
            self.exempt = inputs
            self.update_denied()
            self.unlock(state)

    def take_lost(self):
        """Return the mask of the outputs that have been switched off, or were asked for in vain, since the last call."""
        state = self.lock()
        lost = self.lost
        self.lost = 0
        self.unlock(state)
        return lost

    def read(self, states):
        """Take over the inputs' states as they are, at the start."""
        self.states = states
        self.update_denied()

    def refusal_mask(self, steps, tool):
        """Return the forbidden bits of a motion, 0 if it is allowed: `steps` of each axis (None: none), `tool` on."""
        wanted = INTERLOCK_TOOL if tool else 0
        for axis in range(len(steps)):
            if steps[axis]:
                wanted |= (1 if steps[axis] > 0 else 2) << 2 * axis
        return self.denied & wanted

    def output(self, name, on):
        """Ask for an output, or no longer; its pin follows if it is allowed."""
        bit = INTERLOCK_OUTPUTS << self._outputs.index(name)
        state = self.lock()
        if on and not self.denied & bit:
            self.asked |= bit
        else:
            self.asked &= ~bit
            if on:
                self.lost |= bit
                self._lost_states = self.states
        self.put_outputs(bit, 1 if (self.asked | self.granted) & bit else 0)
        self.unlock(state)

    def outputs_to_grant(self):
        """Return the mask of the outputs that the equations switch on though the board does not ask."""
        return self._unasked[PERMIT_GATED] & ~find_denied(self._unasked, self.states) & ~self.denied

    def grant_outputs(self, mask):
        """Switch on outputs of `mask` that the board has not asked for, as far as that is allowed now."""
        state = self.lock()
        mask &= self.outputs_to_grant()
        self.granted |= mask
        self.put_outputs(mask, 1)
        self.unlock(state)
