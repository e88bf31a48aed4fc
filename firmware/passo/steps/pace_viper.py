"""Pacing: gives the step masks of a segment their ticks.

    pace(words, at, count, interval)       # masks to words
    debt = repay(words, at, count, bits, debt, least)

`count` steps share `ticks` evenly: each interval is the floor or the ceiling of ticks / count, and the total is exact.
A segment that runs over the end of the ring is paced in two calls; the second goes on with the first one's carry. `interval`:
PACE_… of records.py, with which the feeder's state begins. One text for all interpreters; see motion/block_viper.py.
"""
# Shared with interrupts: interval

import micropython

from passo.records import *


@micropython.viper
def pace(words: ptr32, at: int, count: int, interval: ptr32):  # ISR: no allocation
    """Turn the masks in words[at : at + count], count ≥ 1, into words."""
    short = interval[PACE_SHORT]
    tick = interval[PACE_TICK]
    rest = interval[PACE_REST]
    over = interval[PACE_OVER]
    carry = interval[PACE_CARRY]
    end = at + count
    while at < end:
        carry += rest
        word = words[at] | short
        if carry >= over:
            carry -= over
            word += tick
        words[at] = word
        at += 1
    interval[PACE_CARRY] = carry


@micropython.viper
def repay(words: ptr32, at: int, count: int, bits: int, debt: int, least: int) -> int:  # ISR: no allocation
    """Take `debt` ticks off words[at : at + count], none falling below `least`. Returns the debt that remains."""
    end = at + count
    while at < end and debt:
        word = words[at]
        spare = (word >> bits) - least
        if spare > 0:
            if spare > debt:
                spare = debt
            words[at] = word - (spare << bits)
            debt -= spare
        at += 1
    return debt
