"""Pacing: gives the step masks of a segment their ticks.

`count` steps share `ticks` evenly: each interval is the floor or the ceiling of ticks / count, and the total is exact.
A segment that runs over the end of the ring is paced in two calls; the second goes on with the first one's carry.
"""

from array import array

from micropython import const

# The terms of a segment, in one array for the sake of the twin in machine code.
SHORT = const(0)  # a word of the shorter interval, without its mask
TICK = const(1)  # one tick in a word
REST = const(2)  # rest / over: the share of the intervals that are a tick longer
OVER = const(3)
CARRY = const(4)
TERMS = const(5)  # how many there are


def new_terms():
    return array("i", [0] * TERMS)


def set_terms(terms, steps, ticks, base, bits):  # ISR: no allocation
    """For a segment of `steps` that last `ticks`, `base` being ORed to their levels."""
    terms[SHORT] = ticks // steps << bits | base
    terms[TICK] = 1 << bits
    terms[REST] = ticks % steps
    terms[OVER] = steps
    terms[CARRY] = 0


def pace(words, at, count, terms):  # ISR: no allocation
    """Turn the masks in words[at : at + count], count ≥ 1, into words."""
    short = terms[SHORT]
    rest = terms[REST]
    over = terms[OVER]
    carry = terms[CARRY]
    for i in range(at, at + count):
        word = short | words[i]
        carry += rest
        if carry >= over:
            carry -= over
            word += terms[TICK]
        words[i] = word
    terms[CARRY] = carry


def repay(words, at, count, bits, debt, least):  # ISR: no allocation
    """Take `debt` ticks off words[at : at + count], none falling below `least`. Returns the debt that remains."""
    for i in range(at, at + count):
        if not debt:
            return 0
        word = words[i]
        spare = (word >> bits) - least
        if spare > 0:
            if spare > debt:
                spare = debt
            words[i] = word - (spare << bits)
            debt -= spare
    return debt
