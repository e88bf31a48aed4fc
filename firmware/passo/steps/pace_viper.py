"""pace_plain.pace and repay as machine code of the board. See there; they give the same bits."""
# ruff: noqa: F821

import micropython


@micropython.viper
def pace(words: ptr32, at: int, count: int, terms: ptr32):
    short = terms[0]
    tick = terms[1]
    rest = terms[2]
    over = terms[3]
    carry = terms[4]
    end = at + count
    while at < end:
        carry += rest
        word = words[at] | short
        if carry >= over:
            carry -= over
            word += tick
        words[at] = word
        at += 1
    terms[4] = carry


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
