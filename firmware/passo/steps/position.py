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


try:
    from passo.steps.position_viper import advance
except (ImportError, NameError, ValueError):  # an interpreter that has no machine code of its own
    advance = advance_plain
