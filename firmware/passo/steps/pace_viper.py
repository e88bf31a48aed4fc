"""pace_plain.pace and repay as machine code of the board. See there; they give the same bits."""
# ruff: noqa: F821

import micropython

from passo.records import PACE_CARRY, PACE_OVER, PACE_REST, PACE_SHORT, PACE_TICK


@micropython.viper
def pace(words: ptr32, at: int, count: int, terms: ptr32):
    short = terms[PACE_SHORT]
    tick = terms[PACE_TICK]
    rest = terms[PACE_REST]
    over = terms[PACE_OVER]
    carry = terms[PACE_CARRY]
    end = at + count
    while at < end:
        carry += rest
        word = words[at] | short
        if carry >= over:
            carry -= over
            word += tick
        words[at] = word
        at += 1
    terms[PACE_CARRY] = carry


@micropython.viper
def repay(words: ptr32, at: int, count: int, bits: int, debt: int, least: int) -> int:
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
