"""From step words to frames of an I2S, and from frames played to words played. One text for all interpreters: a board
compiles it to machine code, elsewhere it is ordinary Python.

    word      |step x, 208 ticks        |step y, 208 ticks        |
    frames    |X |  |  |  |X... of 50 ticks: 4 µs; each edge is on the frame nearest to its word's beginning
    rest      what of the words' ticks is not in frames yet: it is carried to the next word and never grows

`state` is an array('i') of the fields below. Frame numbers and words run modulo 2²⁹.
"""

import micropython
from micropython import const

from passo.records import COUNT_MASK

FRAME_TICKS = const(50)  # 4 µs
HALF_TICKS = const(25)
BIAS = const(1 << 24)
ON_A_FRAME = const((1 << 24) + 25)  # REST of a word that begins on a frame
FRAME = const(0)  # number of the next frame to be made
NEXT = const(1)  # count of the next word to be turned into frames
HEAD = const(2)  # count up to which there are words
MASK = const(3)  # size of the ring − 1
BITS = const(4)  # of a word's levels
LEFT = const(5)  # frames of the word under way that are not made yet
FALL = const(6)  # of these, the number that its pulses stay high
REST = const(7)  # ticks plus BIAS: they may be negative, and a value read from an array has no sign
LEVELS = const(8)  # of the word under way, or of the rest
PULSES = const(9)  # mask of the levels that are pulses
PULSE_FRAMES = const(10)
FLIP = const(11)  # bits of a frame that are inverted, and outputs that are on
KEEP = const(12)  # bits of a frame that are no pulses
IDLE = const(13)  # 1: there was no word for the last frame made
PLAYED = const(14)  # words whose first frame has been latched
SHOWN = const(15)  # levels of the last of them
ENDS = const(16)  # number of the frame at which the last word made ends
RUNS = const(17)  # 1: that frame has not been latched yet
FIELDS = const(18)


@micropython.viper
def make(frames: ptr32, i: int, run: int, count: int, state: ptr32, words: ptr32, starts: ptr32, table: ptr32):
    """Write `count` frames. `table`: frames of the low seven bits of levels, then of the seven above. `starts`: for each
    word of the ring the number of its first frame. `i` and `run` are 0: locals that stand first, and so in registers."""
    mask = state[MASK]
    bits = state[BITS]
    next = state[NEXT]
    head = state[HEAD]
    left = state[LEFT]
    fall = state[FALL]
    rest = int(state[REST]) - BIAS
    levels = state[LEVELS]
    pulses = state[PULSES]
    first = state[FRAME]
    idle = 0
    high = (table[levels & 127] | table[128 + ((levels >> 7) & 127)]) ^ state[FLIP]
    low = high & state[KEEP]
    while i < count:
        if left == 0:
            if next == head:
                levels = levels & (pulses ^ 0x3FFF)
                if state[IDLE] == 0 or next != state[NEXT]:
                    state[ENDS] = (first + i) & COUNT_MASK
                idle = 1
                rest = HALF_TICKS  # the next word begins on a frame
                fall = 0
                left = count - i
            else:
                word = words[next & mask]
                levels = word & ((1 << bits) - 1)
                rest += word >> bits
                if rest < FRAME_TICKS:
                    left = 1  # every word is seen; the next ones are shorter by the difference
                elif rest < 0x8000:
                    left = (rest * 5243) >> 18  # by FRAME_TICKS
                else:
                    left = rest // FRAME_TICKS
                rest -= left * FRAME_TICKS
                starts[next & mask] = (first + i) & COUNT_MASK
                next = (next + 1) & COUNT_MASK
                high = (table[levels & 127] | table[128 + ((levels >> 7) & 127)]) ^ state[FLIP]
                low = high & state[KEEP]
                fall = state[PULSE_FRAMES] if levels & pulses else 0
        run = left
        if fall and fall < run:
            run = fall
        if run > count - i:
            run = count - i
        left -= run
        if fall:
            fall -= run
            run += i
            while i < run:
                frames[i] = high
                i += 1
        else:
            run += i
            while i + 8 <= run:
                frames[i] = low
                frames[i + 1] = low
                frames[i + 2] = low
                frames[i + 3] = low
                frames[i + 4] = low
                frames[i + 5] = low
                frames[i + 6] = low
                frames[i + 7] = low
                i += 8
            while i < run:
                frames[i] = low
                i += 1
    if not idle:
        state[ENDS] = (first + count + left) & COUNT_MASK
    if next != state[NEXT]:
        state[RUNS] = 1
    state[IDLE] = idle
    state[FRAME] = (first + count) & COUNT_MASK
    state[NEXT] = next
    state[LEFT] = left
    state[FALL] = fall
    state[REST] = rest + BIAS
    state[LEVELS] = levels


@micropython.viper
def advance(state: ptr32, words: ptr32, starts: ptr32, frame: int):
    """Count the words played: `frame` is the number of frames latched."""
    mask = state[MASK]
    played = state[PLAYED]
    made = state[NEXT]
    while played != made and ((frame - 1 - starts[played & mask]) & COUNT_MASK) < 0x10000000:
        state[SHOWN] = words[played & mask] & ((1 << state[BITS]) - 1)
        played = (played + 1) & COUNT_MASK
    state[PLAYED] = played
    if played == made and ((frame - state[ENDS]) & COUNT_MASK) < 0x10000000:
        state[RUNS] = 0
