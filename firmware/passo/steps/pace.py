"""Pacing: gives the step masks of a segment their ticks.

`count` steps share `ticks` evenly: each interval is the floor or the ceiling of ticks / count, and the total is exact.
A segment that runs over the end of the ring is paced in two calls; the second goes on with the first one's carry.
"""


def pace(words, at, count, base, bits, each, rest, over, carry):  # ISR: no allocation
    """Turn the masks in words[at : at + count] into words: `base` is ORed to their levels, `each` ticks and a share of
    `rest` / `over` to their time. Returns the carry for the next call."""
    for i in range(at, at + count):
        ticks = each
        carry += rest
        if carry >= over:
            carry -= over
            ticks += 1
        words[i] = ticks << bits | base | words[i]
    return carry


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
