"""Rows of dots: a line whose power changes at equal distances along it, exact to the step.

    burn(state, rows, power, path, words, at, part, run)    # segments_viper.py: while it writes a segment of a row

    row      |  0  |  1  |  2  |        n dots over s steps: dot i begins at the step nearest to i · s / n
    steps    . . . . . . . . . .
    marks    ^     ^     ^              none if the power stays

The tool's bit is on in the steps of each dot that burns, so it is exact to the step, too. A row with more dots than steps leaves out
those that have none.

Behind a row that ends at rest the last interval is cut into several words, `part` being 0: a Pico hears of a mark POWER_AHEAD words ahead of
its own (options/spindle_pwm/port_rp2.py), and no other words may follow. One text for all interpreters; see motion/block_viper.py. Fields: records.py.
"""
# Shared with interrupts: state, power
# `burn` of passo.steps.segments_viper is usually this one

import micropython
from micropython import const

from passo.motion.line import MAX_RUN
from passo.records import *
from passo.steps.segments_viper import put_mark

_LEAST = const(125)  # ticks of such a word


@micropython.viper
def burn(state: ptr32, rows: ptr32, power: ptr32, path: ptr32, words: ptr32, at: int, part: int, run: int):  # ISR: no allocation
    """Put the marks of the steps words[at : at + part], and the tool's bit, before they are paced; the segment has `run` steps from there
    on. Behind the row's last step its dots are given back."""
    if part == 0:
        pad(state, words, rows[state[FEED_ROW] + ROW_DYNAMIC])
        return
    tool = state[FEED_TOOL]
    row = rows[state[FEED_ROW] + ROW_POWER]
    count = row >> DOTS_COUNT & DOTS_MOST
    first = row >> DOTS_FIRST
    total = path[LINE_FALL] >> 1
    step = state[FEED_INDEX] - run
    word = state[FEED_HEAD] + state[FEED_STEPS] - run - step
    end = step + part
    at -= step
    dot = step * count // total
    burns = 0
    while step < end:
        until = int(end_of(dot, count, total))
        if until > end:
            until = end
        if step < until:
            burns = (first + dot) & power[DOTS_MASK]
            burns = power[power[DOTS_AT] + burns // 3] >> burns % 3 * DOTS_COUNT & DOTS_POWER
            put_mark(state, power, (word + step) & COUNT_MASK, int(level_of(state, rows, burns)))
            if burns:
                burns = tool
            while step < until:
                words[at + step] = words[at + step] | burns
                step += 1
        dot += 1
    state[PACE_SHORT] = state[PACE_SHORT] & ~tool
    state[FEED_LEVELS] = state[FEED_LEVELS] & ~tool | burns
    if end == total:
        power[DOTS_TAIL] = (first + count) & power[DOTS_MASK]


@micropython.viper
def pad(state: ptr32, words: ptr32, dynamic: int):  # ISR: no allocation
    """The last interval of the segment in several words, the last of which is dark if the power follows the speed: it is 0 at a stand, which
    the main loop would see to 3 ms later."""
    at = state[FEED_HEAD] + state[FEED_STEPS] - 1
    word = words[at & state[FEED_MASK]]
    bits = state[FEED_BITS]
    each = ((word >> bits) - _LEAST) // POWER_AHEAD
    if each < _LEAST or state[FEED_STEPS] + POWER_AHEAD > MAX_RUN:
        return
    words[at & state[FEED_MASK]] = word - (((POWER_AHEAD - 1) * each + _LEAST) << bits)
    levels = word & (1 << bits) - 1
    if state[FEED_DRIVE] == 0:
        levels &= ~((1 << state[FEED_AXES]) - 1)
    left = POWER_AHEAD
    while left:
        at += 1
        left -= 1
        if left == 0:
            each = _LEAST
            if dynamic:
                levels &= ~state[FEED_TOOL]
                state[FEED_LEVELS] = state[FEED_LEVELS] & ~state[FEED_TOOL]
        words[at & state[FEED_MASK]] = each << bits | levels
    state[FEED_STEPS] = state[FEED_STEPS] + POWER_AHEAD


@micropython.viper
def end_of(dot: int, count: int, total: int) -> int:  # ISR: no allocation
    """Return the step at which the next dot begins."""
    return (2 * (dot + 1) * total + count) // (2 * count)


@micropython.viper
def level_of(state: ptr32, rows: ptr32, burns: int) -> int:  # ISR: no allocation
    """A dot's power in the segment under way, as a mark's."""
    row = state[FEED_ROW]
    speed = state[FEED_PACE]
    level = ((burns * (rows[row + ROW_POWER] & DOTS_POWER) << POWER_FINE) + 500) // 1000
    if rows[row + ROW_DYNAMIC] and speed >> 30 & 1 == 0:
        level = (level * speed + (rows[row + ROW_TOP] >> 1)) // rows[row + ROW_TOP]
    return level if level < POWER_MOST << POWER_FINE else POWER_MOST << POWER_FINE
