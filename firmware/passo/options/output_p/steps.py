"""Outputs that change with the first step of a motion: M62 and M63 as marks in the step stream.

    switches = Switches(feeder, player, machine)
    port.switching.show_switches(switches)      # a part of the port
    switches.ask_change(queue.blocks_queued(), 17 << 1 | 1)  # pin 17 high as the next block begins that moves
    switches.take_shown()                       # how many have been shown since

The main loop asks; start(), which the port puts in the place of player.start(), finds the word of each; the port shows it as that word begins:
each writes its own field of `marks`.

A block begins at the mark that ends the one before it. A change waits for the first one that is no dwell, and for its first step: a word
that only turns a direction comes before that.

    words   . . a a a a t b b b b c c       block b has turned an axis; a change that came before b is due at its first b
    marks   |           |         |         FEED_OLDEST … FEED_NEWEST

find_words() is one text for all interpreters; see motion/block_viper.py.
"""
# Shared with interrupts: switches, state, marks, indices

import micropython
from micropython import const

from passo.arrays import zeros
from passo.records import *

# Switches.marks. First how many changes were asked for and shown, for ever, modulo 2²⁹.
SWITCH_ASKED = const(0)
SWITCH_SHOWN = const(1)
SWITCH_PULSES = const(2)  # mask of a word's pulses
SWITCH_STRIDE = const(3)  # integers a row of the planner
SWITCH_FIRST = const(4)  # then a ring of them
SWITCH_MOST = const(16)  # a power of two
# A change:
SWITCH_BLOCK = const(0)  # count of the block that it begins with
SWITCH_WORD = const(1)  # count of that block's first word that steps, modulo 2²⁹; SWITCH_NEVER: not known yet
SWITCH_VALUE = const(2)  # pin << 1 | level
SWITCH_FIELDS = const(3)
SWITCH_NEVER = const(0x20000000)


@micropython.viper
def find_words(switches: ptr32, state: ptr32, marks: ptr32, words: ptr32, rows: ptr32, indices: ptr32) -> int:  # ISR: no allocation
    """Write the word of each change, or SWITCH_NEVER while it is not known. Returns how many are known. See above."""
    stride = MARK_FIELDS + state[FEED_AXES]
    at = state[FEED_OLDEST]
    count = indices[QUEUE_RETIRED]
    change = switches[SWITCH_SHOWN]
    found = 0
    while change != switches[SWITCH_ASKED]:
        here = SWITCH_FIRST + (change & (SWITCH_MOST - 1)) * SWITCH_FIELDS
        word = SWITCH_NEVER
        while word == SWITCH_NEVER:
            block = switches[here + SWITCH_BLOCK]
            mark = (at & (MARKS - 1)) * stride
            if (count - block) & COUNT_MASK < COUNT_HALF and (count != block or marks[mark + MARK_ENDS] == 0):
                word = (state[FEED_PLAYED] - 1) & COUNT_MASK  # it has begun
            elif at == state[FEED_NEWEST]:
                break
            elif count != block:
                at = (at + 1) & COUNT_MASK
                count = (count + marks[(at & (MARKS - 1)) * stride + MARK_ENDS]) & COUNT_MASK
            elif rows[block % QUEUE_SIZE * switches[SWITCH_STRIDE] + ROW_KIND] == KIND_WAIT:
                switches[here + SWITCH_BLOCK] = (block + 1) & COUNT_MASK
            else:
                word = marks[mark + MARK_WORD]
                if switches[SWITCH_PULSES] and words[word & state[FEED_MASK]] & switches[SWITCH_PULSES] == 0:
                    word = (word + 1) & COUNT_MASK
        switches[here + SWITCH_WORD] = word
        if word != SWITCH_NEVER:
            found += 1
        change = (change + 1) & COUNT_MASK
    return found


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

    def ask_change(self, block, value):
        """Change a pin with the first step of block number `block` or, if that is a dwell, of the one behind it. At most SWITCH_MOST wait."""
        marks = self.marks
        at = SWITCH_FIRST + (marks[SWITCH_ASKED] & SWITCH_MOST - 1) * SWITCH_FIELDS
        marks[at + SWITCH_BLOCK] = block
        marks[at + SWITCH_WORD] = SWITCH_NEVER
        marks[at + SWITCH_VALUE] = value
        marks[SWITCH_ASKED] = marks[SWITCH_ASKED] + 1 & COUNT_MASK  # last: from here on an interrupt may find it

    def amend_change(self, back, value):
        """Replace the value of the change asked for last, `back` 1, or before it. Only while its block is not queued."""
        self.marks[SWITCH_FIRST + (self.marks[SWITCH_ASKED] - back & SWITCH_MOST - 1) * SWITCH_FIELDS + SWITCH_VALUE] = value

    def withdraw_last(self, count):
        """Forget the `count` changes that were asked for last. Only while their block is not queued."""
        self.marks[SWITCH_ASKED] = self.marks[SWITCH_ASKED] - count & COUNT_MASK

    @micropython.native
    def start(self):  # ISR: no allocation
        """Find the words of the changes, then start the player."""
        marks, state, segments, words, rows, indices = self._arrays
        # Parked, the counts are those of the way there.
        if marks[SWITCH_ASKED] != marks[SWITCH_SHOWN] and not self._shut and not self._machine.away:
            if find_words(marks, state, segments, words, rows, indices) and self.tell:
                self.tell()
        return self._start()

    def join(self, tell):
        """Have start() call tell() from here on."""
        self.tell = tell

    def take_shown(self):
        """Return how many changes have been shown since the last call: the oldest ones."""
        shown = self.marks[SWITCH_SHOWN]
        count = shown - self._counted & COUNT_MASK
        self._counted = shown
        return count

    def clear_changes(self):
        """Forget the changes that have not been shown."""
        marks = self.marks
        self._shut = True
        for at in range(SWITCH_FIRST + SWITCH_WORD, len(marks), SWITCH_FIELDS):
            marks[at] = SWITCH_NEVER
        marks[SWITCH_ASKED] = marks[SWITCH_SHOWN]
        self._shut = False

    def show_due(self, played, put):
        """For a port without interrupts: call put(value) for each change due now that `played` words have begun. Returns the word of the next one, or
        SWITCH_NEVER."""
        marks = self.marks
        while marks[SWITCH_ASKED] != marks[SWITCH_SHOWN]:
            at = SWITCH_FIRST + (marks[SWITCH_SHOWN] & SWITCH_MOST - 1) * SWITCH_FIELDS
            word = marks[at + SWITCH_WORD]
            if word == SWITCH_NEVER or played - 1 - word & COUNT_MASK >= COUNT_HALF:
                return word
            marks[SWITCH_SHOWN] = marks[SWITCH_SHOWN] + 1 & COUNT_MASK
            put(marks[at + SWITCH_VALUE])
        return SWITCH_NEVER
