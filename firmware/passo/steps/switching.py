"""Outputs that change with the first step of a motion: M62 and M63 as marks in the step stream.

    switches = Switches(feeder, player, machine)
    port.make("switching", switches)            # True: the port shows them
    switches.ask(queue.added(), 17 << 1 | 1)    # pin 17 high as the next block begins that moves
    switches.shown()                            # how many have been shown since

The main loop asks; start(), which the port puts in the place of player.start(), finds the word of each; the port shows it as that word begins:
each writes its own field of `marks`.
"""

import micropython

from passo.memory import zeros
from passo.records import *
from passo.steps.switching_records import *
from passo.steps.switching_viper import find


class Switches:
    def __init__(self, feeder, player, machine):
        self.marks = marks = zeros(SWITCH_FIRST + SWITCH_MOST * SWITCH_FIELDS)
        planner = feeder.planner
        marks[SWITCH_PULSES] = feeder.layout.pulse_mask
        marks[SWITCH_STRIDE] = planner.scratch[SCRATCH_STRIDE]
        self._machine = machine
        self._shut = False  # the main loop clears
        self._counted = 0
        self._arrays = marks, feeder.state, feeder.marks, feeder.ring.words, planner.rows, planner.indices
        self._start = player.start
        self.tell = None  # the port's function that start() calls while words of changes are known

    def ask(self, block, value):
        """Change a pin with the first step of block number `block` or, if that is a dwell, of the one behind it. At most SWITCH_MOST wait."""
        marks = self.marks
        at = SWITCH_FIRST + (marks[SWITCH_ASKED] & SWITCH_MOST - 1) * SWITCH_FIELDS
        marks[at + SWITCH_BLOCK] = block
        marks[at + SWITCH_WORD] = SWITCH_NEVER
        marks[at + SWITCH_VALUE] = value
        marks[SWITCH_ASKED] = marks[SWITCH_ASKED] + 1 & COUNT_MASK  # last: from here on an interrupt may find it

    def amend(self, back, value):
        """The change that was asked for last, `back` 1, or before it, is another one. Only while its block is not queued."""
        self.marks[SWITCH_FIRST + (self.marks[SWITCH_ASKED] - back & SWITCH_MOST - 1) * SWITCH_FIELDS + SWITCH_VALUE] = value

    @micropython.native
    def start(self):  # ISR: no allocation
        """The player's start()."""
        marks, state, segments, words, rows, indices = self._arrays
        # Parked, the counts are those of the way there.
        if marks[SWITCH_ASKED] != marks[SWITCH_SHOWN] and not self._shut and not self._machine.away:
            if find(marks, state, segments, words, rows, indices) and self.tell:
                self.tell()
        return self._start()

    def join(self, tell):
        """Have start() call tell() from here on."""
        self.tell = tell

    def shown(self):
        """How many changes have been shown since the last call: the oldest ones."""
        shown = self.marks[SWITCH_SHOWN]
        count = shown - self._counted & COUNT_MASK
        self._counted = shown
        return count

    def clear(self):
        """Forget those that have not been shown."""
        marks = self.marks
        self._shut = True
        for at in range(SWITCH_FIRST + SWITCH_WORD, len(marks), SWITCH_FIELDS):
            marks[at] = SWITCH_NEVER
        marks[SWITCH_ASKED] = marks[SWITCH_SHOWN]
        self._shut = False

    def show(self, played, put):
        """For a port without interrupts: put(value) for each change that is due now that `played` words have begun. Returns the next one's word."""
        marks = self.marks
        while marks[SWITCH_ASKED] != marks[SWITCH_SHOWN]:
            at = SWITCH_FIRST + (marks[SWITCH_SHOWN] & SWITCH_MOST - 1) * SWITCH_FIELDS
            word = marks[at + SWITCH_WORD]
            if word == SWITCH_NEVER or played - 1 - word & COUNT_MASK >= COUNT_HALF:
                return word
            marks[SWITCH_SHOWN] = marks[SWITCH_SHOWN] + 1 & COUNT_MASK
            put(marks[at + SWITCH_VALUE])
        return SWITCH_NEVER
