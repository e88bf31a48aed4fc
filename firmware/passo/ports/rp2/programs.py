"""The PIO programs of the players. One tick of 80 ns costs `cycles` state machine cycles (10 at 125 MHz).

Every path through a program is a whole number of ticks: what pulling a word and setting the pins costs is hidden in the
word's own first ticks, which x counts down without a loop. So a word of n ticks lasts n · `cycles` exactly, and words
need no correction. `pull` and `out(pins)` are neighbours: a state machine frozen between them is recognised by its
address (see PULL and OUT), and the word in hand counts as not played.

Where there is a halt pin, the wait stands still for as long as that pin is high: no edge comes any more, whatever the
processor is doing, and a spike of noise costs its own length and nothing else.
"""

import rp2

PULL = 0  # addresses within each program
OUT = 1


def steps(bits, cycles, halt):
    """Pulses: the pins of `set` fall ISR + 2 ticks after the word begins. Words of at least ISR + 4 ticks."""
    time_bits = 32 - bits
    settle = cycles - 3  # puts the fall on a whole tick after the rise
    rest = cycles - 5  # of the ticks that the three lone decrements stand for

    @rp2.asm_pio(out_shiftdir=rp2.PIO.SHIFT_RIGHT, fifo_join=rp2.PIO.JOIN_TX)
    def program():
        wrap_target()
        pull(block)
        out(pins, bits)  # rise
        out(x, time_bits)
        mov(y, isr)[settle]
        label("high")
        jmp(x_dec, "counted")
        label("counted")
        jmp(y_dec, "high")[cycles - 2]
        set(pins, 0)  # fall
        jmp(x_dec, "second")
        label("second")
        jmp(x_dec, "third")
        label("third")
        jmp(x_dec, "low")[rest]
        label("low")
        if halt:
            jmp(pin, "low")
            jmp(x_dec, "low")[cycles - 2]
        else:
            jmp(x_dec, "low")[cycles - 1]
        wrap()

    return program


def levels(bits, cycles, halt):
    """Levels that hold until the next word: coils. Words of at least 2 ticks."""
    time_bits = 32 - bits
    rest = cycles - 5

    @rp2.asm_pio(out_shiftdir=rp2.PIO.SHIFT_RIGHT, fifo_join=rp2.PIO.JOIN_TX)
    def program():
        wrap_target()
        pull(block)
        out(pins, bits)
        out(x, time_bits)[rest]
        jmp(x_dec, "second")
        label("second")
        jmp(x_dec, "low")
        label("low")
        if halt:
            jmp(pin, "low")
            jmp(x_dec, "low")[cycles - 2]
        else:
            jmp(x_dec, "low")[cycles - 1]
        wrap()

    return program


def clock(bits, cycles):
    """No pins: raises its interrupt as a word begins. Words of at least 2 ticks."""
    time_bits = 32 - bits
    rest = cycles - 6

    @rp2.asm_pio(out_shiftdir=rp2.PIO.SHIFT_RIGHT, fifo_join=rp2.PIO.JOIN_TX)
    def program():
        wrap_target()
        pull(block)
        irq(rel(0))
        out(null, bits)
        out(x, time_bits)[rest]
        jmp(x_dec, "second")
        label("second")
        jmp(x_dec, "low")
        label("low")
        jmp(x_dec, "low")[cycles - 1]
        wrap()

    return program
