"""Runs on the board, behind board_witness.py: a spare PIO state machine as a logic analyser of eight channels.

    samples = bytearray(32768)                          # made first, while memory is free in large pieces
    analyser = Analyser(2, samples, 8, (RISE, 5))       # GPIO2 to GPIO9, from the next rise of GPIO5 on, each 8 cycles of the system clock
    analyser = Analyser(2, samples, 8, (WORD, 0b101, 3))    # once the first three channels are 1, 0, 1
    analyser = Analyser(2, samples, 8)                  # at once
    record(analyser, 10000)                             # waits for the trigger; or play(lines, analyser)

A sample is a byte, the first channel in its lowest bit, taken in every cycle of the state machine, whose clock is the sampling rate: nothing but
the memory's room bounds it up to the system clock, and DMA has room for 25 MHz beside a player. A rise that is shorter than a sample, and a word
that lasts less than four, are not seen. The pins are looked at; only their inputs are switched on.
"""

from time import sleep_ms, ticks_diff, ticks_ms

import rp2
from machine import mem32

FALL, RISE, WORD = 0, 1, 2

try:
    from board import BOARD

    from passo.ports.safe import outputs, safe

    safe(outputs(BOARD))  # a board with Passo on it: the motors' current is off, and stays so
except ImportError:
    pass


def edge_of(trigger):
    return bool(trigger) and trigger[0] != WORD


def recorder_program(trigger):
    """Return the PIO program of the recorder: wait for `trigger` (None: begin at once), then sample 8 pins each cycle."""
    kind, pin, width = (trigger + (1,))[:3] if trigger else (None, 0, 1)
    word, edge = kind == WORD, edge_of(trigger)  # an assembler's function sees no globals

    @rp2.asm_pio(in_shiftdir=rp2.PIO.SHIFT_RIGHT, fifo_join=rp2.PIO.JOIN_RX, autopush=True, push_thresh=32)
    def program():
        """Sample 8 pins each cycle, 4 samples a word of the FIFO."""
        if word:
            label("look")
            mov(isr, null)  # nothing seen yet
            in_(pins, width)  # the first channels
            mov(x, isr)  # to be compared
            jmp(x_not_y, "look")  # with the word
            mov(isr, null)  # the samples begin at the lowest byte
        elif edge:
            wait(1 - kind, gpio, pin)  # the other level first: it is an edge that counts
            wait(kind, gpio, pin)  # the edge
        wrap_target()
        in_(pins, 8)  # a sample; each fourth time all of them go to the FIFO, and so to memory
        wrap()

    return program


class Analyser(Witness):
    def __init__(self, base, samples, divider, trigger=()):
        """`samples`: a bytearray for them; `divider`: cycles of the system clock to a sample, at most 65535."""
        self._divider, self._trigger = divider, trigger
        for pin in list(range(base, base + 8)) + [trigger[1]] * edge_of(trigger):
            mem32[pad_address(pin)] = mem32[pad_address(pin)] & ~0x100 | 0x40  # the input is on; an RP2350's pad holds nothing
        super().__init__(base, 8, samples, 4, recorder_program(trigger))

    def prepare_program(self):
        """Put the word into Y, shifted to the highest bits, as the program has the levels, and set the clock divider."""
        if self._trigger and self._trigger[0] == WORD:
            _word, value, width = self._trigger
            parts = [(value & 31, min(width, 5)), (value >> 5, width - 5)]
            loads = [part for bits, count in parts if count > 0 for part in ("set(x, %d)" % bits, "in_(x, %d)" % count)]
            for instruction in ["mov(isr, null)"] + loads + ["mov(y, isr)", "mov(isr, null)"]:
                self._machine.exec(instruction)
        mem32[self._wrap - 4] = self._divider << 16  # CLKDIV: whole cycles, which a frequency in hertz would not always give

    def is_full(self):
        return self._dma.count == 0


def record(analyser, limit_ms):
    """Wait for the trigger and for as many samples as there is room for, and print them."""
    analyser.start()
    end = ticks_ms() + limit_ms
    while not analyser.is_full() and ticks_diff(end, ticks_ms()) > 0:
        sleep_ms(1)
    analyser.stop()
    print("\n=", 0, analyser.taken, 1)
    analyser.print_records()
