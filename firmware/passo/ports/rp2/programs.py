"""The PIO programs of the players. One tick of 80 ns costs `cycles` state machine cycles (10 at 125 MHz).

Every path through a program is a whole number of ticks: the cycles for pulling a word and setting the pins are part of the word's own first
ticks, which x counts down without a loop. So a word of n ticks lasts n · `cycles` exactly, and words need no correction. `[n]` is n cycles
of waiting behind an instruction. `pull` and `out(pins)` are neighbours: a state machine frozen between them is recognised by its address
(see PULL and OUT), and the word in hand counts as not played.

With a halt pin, the wait stands still for as long as that pin is high: no edge comes any more, whatever the processor is doing, and a spike
of noise costs its own length alone.
"""

import rp2

PIO_0 = 0x50200000  # address of the block whose state machine 0 plays; beyond 2³⁰, so no constant that the build puts in
PULL = 0  # addresses within each program
OUT = 1


def steps(bits, cycles, halt):
    """Pulses: the pins of `set` fall ISR + 2 ticks after the word begins. Words of at least ISR + 4 ticks."""
    time_bits = 32 - bits
    settle = cycles - 4  # puts the fall on a whole tick after the rise
    rest = cycles - 5  # of the ticks that the three lone decrements stand for

    @rp2.asm_pio(out_shiftdir=rp2.PIO.SHIFT_RIGHT, fifo_join=rp2.PIO.JOIN_TX)
    def program():
        wrap_target()
        pull(block)  # the next word; wait for it
        out(pins, bits)  # its levels: pulses rise
        irq(rel(0))  # it has begun: see options/output_p
        out(x, time_bits)  # its ticks
        mov(y, isr)[settle]  # how long pulses last
        label("high")
        jmp(x_dec, "counted")  # one tick off; never jumps anywhere else
        label("counted")
        jmp(y_dec, "high")[cycles - 2]  # the pulse's next tick
        set(pins, 0)  # pulses fall
        jmp(x_dec, "second")  # three ticks off at once: of pulling, of the fall,
        label("second")
        jmp(x_dec, "third")  # and of the last round of the wait,
        label("third")
        jmp(x_dec, "low")[rest]  # with the cycles missing to whole ones
        label("low")
        if halt:
            jmp(pin, "low")  # the halt pin is high: stand still
            jmp(x_dec, "low")[cycles - 2]  # the ticks that are left
        else:
            jmp(x_dec, "low")[cycles - 1]  # the ticks that are left
        wrap()

    return program


def levels(bits, cycles, halt, shown=True):
    """Levels that hold until the next word: coils. Words of at least 2 ticks. Not `shown`: the player's interrupt sets the pins."""
    time_bits = 32 - bits
    rest = cycles - 6

    @rp2.asm_pio(out_shiftdir=rp2.PIO.SHIFT_RIGHT, fifo_join=rp2.PIO.JOIN_TX)
    def program():
        wrap_target()
        pull(block)  # the next word; wait for it
        if shown:
            out(pins, bits)  # its levels
            irq(rel(0))  # it has begun
        else:
            irq(rel(0))  # it has begun
            out(null, bits)  # the levels are the interrupt's
        out(x, time_bits)[rest]  # its ticks, and the cycles missing to a whole one
        jmp(x_dec, "second")  # these took a tick that x does not know of
        label("second")
        jmp(x_dec, "low")  # the last round of the wait takes one, too
        label("low")
        if halt:
            jmp(pin, "low")  # the halt pin is high: stand still
            jmp(x_dec, "low")[cycles - 2]  # the ticks that are left
        else:
            jmp(x_dec, "low")[cycles - 1]  # the ticks that are left
        wrap()

    return program
