"""At which word each change of switching.py is due: the kernel in front of the player's start().

    find(switches, state, marks, words, rows, indices)      # behind Feeder.fill(), as its words are handed over

A block begins at the mark that ends the one before it. A change waits for the first one that is no dwell, and for its first step: a word
that only turns a direction comes before that.

    words   . . a a a a t b b b b c c       block b has turned an axis; a change that came before b is due at its first b
    marks   |           |         |         FEED_OLDEST … FEED_NEWEST

One text for all interpreters; see motion/block_viper.py. Fields: records.py, switching_records.py.
"""
# Shared with interrupts: switches, state, marks, indices

import micropython

from passo.motion.block import WAIT
from passo.records import *
from passo.steps.switching_records import *


@micropython.viper
def find(switches: ptr32, state: ptr32, marks: ptr32, words: ptr32, rows: ptr32, indices: ptr32) -> int:  # ISR: no allocation
    """Write each change's word, or that it is not known. Returns how many are known."""
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
            elif rows[block % QUEUE_SIZE * switches[SWITCH_STRIDE] + ROW_KIND] == WAIT:
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
