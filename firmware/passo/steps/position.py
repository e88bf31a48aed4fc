"""Positions run modulo 2²⁹, between −2²⁸ and 2²⁸ − 1, for axes that turn for ever."""

from micropython import const

_COUNT = const(0x1FFFFFFF)
_HALF = const(0x10000000)


def advance_plain(position, made, marks, at, axes):  # ISR: no allocation
    """Add the steps `made` to `position` and clear them; write the new position to marks[at:] too."""
    for axis in range(axes):
        place = ((position[axis] + made[axis] + _HALF) & _COUNT) - _HALF
        position[axis] = place
        marks[at + axis] = place
        made[axis] = 0


def tally_plain(words, mask, word, until, axes, position):
    """Add what the words of a ring (its size − 1 is `mask`) from count `word` to `until` step, in the step form, to
    `position`; returns how many of them step."""
    stepping = 0
    steps = (1 << axes) - 1
    while word != until:
        levels = words[word & mask]
        if levels & steps:
            stepping += 1
            for axis in range(axes):
                if levels >> axis & 1:
                    position[axis] += 1 if levels >> axes + axis & 1 else -1
        word = (word + 1) & _COUNT
    return stepping


try:
    from passo.steps.position_viper import advance, tally
except (ImportError, NameError, ValueError):  # an interpreter that has no machine code of its own
    advance, tally = advance_plain, tally_plain
