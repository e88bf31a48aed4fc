"""pace.pace_plain as machine code of the board. See there; the two give the same bits."""
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
