"""The marks of power that a tool's output asks for again and again: which have been played, and what one shows.

    value = passed(power, played)       # of the last mark that began among `played` words, which are given back; -1: none did
    level = scaled(power, value)        # with the override, and a spindle's lowest speed

Both have POWER_FINE bits behind the thousandths.

`power` is Power.marks. One text for all interpreters; see motion/block_viper.py. Fields: records.py.
"""
# Shared with interrupts: power

import micropython

from passo.records import *


@micropython.viper
def passed(power: ptr32, played: int) -> int:  # ISR: no allocation
    """See above."""
    tail = power[POWER_TAIL]
    value = -1
    while tail != power[POWER_HEAD]:
        mark = power[POWER_MARKS + (tail & power[POWER_MASK])]
        if (played - 1 - (mark >> POWER_WORD)) & POWER_WORDS > POWER_WORDS >> 1:
            break
        value = mark & POWER_LEVEL
        tail = (tail + 1) & COUNT_MASK
    power[POWER_TAIL] = tail
    return value


@micropython.viper
def scaled(power: ptr32, value: int) -> int:  # ISR: no allocation
    """What the output shows of a value."""
    if value == 0:
        return 0
    value = value * power[POWER_PERCENT] // 100
    least = power[POWER_LEAST]
    if value >= POWER_MOST << POWER_FINE:
        return POWER_MOST << POWER_FINE
    if least == 0:
        return value
    one = 1 << POWER_FINE
    value -= least << POWER_FINE
    return one if value <= 0 else one + value * (POWER_MOST - 1) // (POWER_MOST - least)
