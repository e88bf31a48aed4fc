"""Pacing: gives the step masks of a segment their ticks.

`count` steps share `ticks` evenly: each interval is the floor or the ceiling of ticks / count, and the total is exact.
A segment that runs over the end of the ring is paced in two calls; the second goes on with the first one's carry.
"""

from array import array

from passo.records import PACE_CARRY, PACE_FIELDS, PACE_OVER, PACE_REST, PACE_SHORT, PACE_TICK

# The terms of a segment, in one array for the sake of the twin in machine code.


def new_terms():
    return array("i", [0] * PACE_FIELDS)


def set_terms(terms, steps, ticks, base, bits):  # ISR: no allocation
    """For a segment of `steps` that last `ticks`, `base` being ORed to their levels."""
    terms[PACE_SHORT] = ticks // steps << bits | base
    terms[PACE_TICK] = 1 << bits
    terms[PACE_REST] = ticks % steps
    terms[PACE_OVER] = steps
    terms[PACE_CARRY] = 0


def pace(words, at, count, terms):  # ISR: no allocation
    """Turn the masks in words[at : at + count], count ≥ 1, into words."""
    short = terms[PACE_SHORT]
    rest = terms[PACE_REST]
    over = terms[PACE_OVER]
    carry = terms[PACE_CARRY]
    for i in range(at, at + count):
        word = short | words[i]
        carry += rest
        if carry >= over:
            carry -= over
            word += terms[PACE_TICK]
        words[i] = word
    terms[PACE_CARRY] = carry


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
