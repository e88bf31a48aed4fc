"""Encoders on the RP2040 and the RP2350: each is counted by a PIO state machine, the processor does nothing per count.

    A  ┌──┐  ┌──┐        B lies on the pin next to A. Forward is A before B: 00 01 11 10 (B first), the count goes up.
      ─┘  └──┘  └─       A state machine looks at both pins every 7 to 10 of its cycles, a 16th of the chip's: at 125 MHz
    B   ┌──┐  ┌──        it keeps up with 780 000 counts a second. A change of both pins at once counts nothing.
      ──┘  └──┘  └

The four state machines of block 1 share one program, which jumps into a table at address 0 and so wants the whole block; the
player has state machine 0 of block 0. Reading four counts takes some 20 µs at 125 MHz.
"""

import micropython
import rp2
from machine import Pin, freq
from micropython import const

from passo.options.encoders.port import Encoders
from passo.ports.rp2.registers import BLOCK_FLEVEL
from passo.records import COUNT_MASK

FIRST = const(4)  # state machine
_DIVIDER = const(16)
_RXF = const(8)  # the RX FIFOs of state machines 0 … 3
# set(y, 0)   mov(isr, null)   in_(pins, 2)   mov(osr, isr): the pins as they are, the first look is no change   jmp("same")
_BEGIN = (0xE040, 0xA0C3, 0x4002, 0xA0E6, 17)
_LOOKS = const(300)  # at a FIFO that is filled every 1.3 µs


@rp2.asm_pio(in_shiftdir=rp2.PIO.SHIFT_LEFT, out_shiftdir=rp2.PIO.SHIFT_RIGHT)
def count_edges():
    """Y is the count, OSR the pins as they were: B, A. 32 instructions long, so that it lies at address 0."""
    # The jumps for the change from the two bits in front to the two behind:
    jmp("same")  # 00 00
    jmp("up")  # 00 01
    jmp("down")  # 00 10
    jmp("same")  # 00 11: a change was missed
    jmp("down")  # 01 00
    jmp("same")  # 01 01
    jmp("same")  # 01 10: missed
    jmp("up")  # 01 11
    jmp("up")  # 10 00
    jmp("same")  # 10 01: missed
    jmp("same")  # 10 10
    jmp("down")  # 10 11
    jmp("same")  # 11 00: missed
    jmp("down")  # 11 01
    jmp("up")  # 11 10
    jmp("same")  # 11 11
    label("down")
    jmp(y_dec, "same")  # one less; it goes on at "same", whether Y was 0 or not
    wrap_target()
    label("same")
    mov(isr, y)  # the count
    push(noblock)  # to the FIFO; dropped if that is full
    out(isr, 2)  # the pins as they were
    in_(pins, 2)  # and behind them as they are
    mov(osr, isr)  # for the next time
    mov(pc, isr)  # into the table
    label("up")
    mov(y, invert(y))  # one more is one less of the complement
    jmp(y_dec, "more")  # goes on at "more" either way
    label("more")
    mov(y, invert(y))  # the count again
    wrap()
    nop()  # never reached, as the next
    nop()
    nop()
    nop()
    nop()
    nop()


class PioEncoders(Encoders):
    def __init__(self, board, port, inputs):
        Encoders.__init__(self, board, port)
        self._machines = []
        for number in range(len(board["encoders"])):
            a, b = board["encoders"][number]["pins"]
            Pin(b, Pin.IN, Pin.PULL_UP)
            machine = rp2.StateMachine(
                FIRST + number, count_edges, freq=freq() // _DIVIDER, in_base=Pin(a, Pin.IN, Pin.PULL_UP)
            )
            for instruction in _BEGIN:
                machine.exec(instruction)
            machine.active(1)
            self._machines.append(machine)
        self.watch_indexes(board, inputs)

    def read(self, counts):  # ISR: no allocation
        """Write the counts, modulo 2²⁹, to `counts`: some 20 µs for four."""
        _read_counts(counts, len(counts))

    def close(self):
        """Stop the state machines."""
        for machine in self._machines:
            machine.active(0)


def create(board, port, inputs, outputs):
    """Return the port's part."""
    return PioEncoders(board, port, inputs)


@micropython.viper
def _read_counts(counts: ptr32, machines: int):
    """Write the counts, modulo 2²⁹, to `counts`. A FIFO holds four old ones, which are thrown away; the next is fresh."""
    block = ptr32(0x50300000)
    number = 0
    while number < machines:
        shift = 8 * number + 4
        old = (block[BLOCK_FLEVEL] >> shift) & 15
        while old:
            old -= 1
            counts[number] = block[_RXF + number] & COUNT_MASK
        tries = _LOOKS
        while tries and (block[BLOCK_FLEVEL] >> shift) & 15 == 0:
            tries -= 1
        if tries:
            counts[number] = block[_RXF + number] & COUNT_MASK
        number += 1
