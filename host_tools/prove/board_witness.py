"""Runs on the board: a spare PIO state machine writes down each change of the pins and its time, DMA carries that into memory.

    witness = Witness(2, 6, RECORDS)    # GPIO2 to GPIO7, at most as many changes as there is room for
    witness.start(); …; witness.stop()
    witness.print_records()                      # prints them in base64

A record is a word: the levels in the low bits moved above a count of passes that runs down. A pass of the program takes 7 cycles of the state
machine, one that writes a record 14: host_tools/prove/edges.py makes times of them. The processor is not asked for anything.
"""

import sys
from binascii import b2a_base64

import machine
import rp2
from machine import Pin, mem32
from uctypes import addressof


RECORDS = bytearray(4 * 2048)  # made first, while memory is free in large pieces


def pad_address(pin):
    """Return the address of the register of a pin's pad."""
    return (0x40038000 if "RP2350" in sys.implementation._machine else 0x4001C000) + 4 + 4 * pin


def witness_program(width):
    """Return the PIO program of the witness of `width` pins."""
    count = 32 - width

    @rp2.asm_pio(in_shiftdir=rp2.PIO.SHIFT_LEFT, fifo_join=rp2.PIO.JOIN_RX)
    def program():
        """Push the levels, with a count of passes below them, each time a pin changes."""
        label("changed")
        mov(y, x)  # the levels as they are from now on
        in_(osr, count)  # the count behind them
        push(noblock)  # to the FIFO, and so to memory
        mov(x, osr)[4]  # the count again; with its wait this pass is as long as two
        jmp(x_dec, "look")  # one less; goes on at "look" either way
        wrap_target()
        label("look")
        mov(isr, null)  # nothing seen yet
        in_(pins, width)  # the levels
        mov(osr, x)  # keep the count
        mov(x, isr)  # the levels, to be compared
        jmp(x_not_y, "changed")
        mov(x, osr)  # the count again
        jmp(x_dec, "look")  # one less; goes on at "look" either way
        wrap()

    return program


class Witness:
    def __init__(self, base, pins, records, number=4, program=None):
        """`number`: of the state machine; `program`: another one than the witness's."""
        block, at = divmod(number, 4)
        self._pio = 0x50200000 + 0x100000 * block
        self._bit = 1 << at
        self._wrap = self._pio + 0xCC + 0x18 * at  # EXECCTRL
        self.room = len(records) // 4
        self._records = records
        self._machine = rp2.StateMachine(number, program or witness_program(pins), in_base=Pin(base))
        self._dma = rp2.DMA()
        self._fifo = self._pio + 0x20 + 4 * at
        self._ctrl = self._dma.pack_ctrl(size=2, inc_read=False, inc_write=True, high_pri=True, treq_sel=8 * block + 4 + at)

    def prepare_program(self):
        """Set the count to its highest, and forget the levels."""
        first = mem32[self._wrap] >> 7 & 31
        for instruction in (0xA02B, 0xA04B, first):  # mov(x, invert(null)), mov(y, invert(null)), jmp("look")
            self._machine.exec(instruction)

    def ready(self):
        """Before start()."""
        self.prepare_program()
        self._dma.config(read=self._fifo, write=addressof(self._records), count=self.room, ctrl=self._ctrl, trigger=True)
        return self._bit

    def start(self, *others):
        """Start with all of `others` in the same cycle."""
        bits = 0
        for each in (self,) + others:
            bits |= each.ready()
        mem32[self._pio + 0x2000] = bits  # sets them in CTRL

    def stop(self):
        mem32[self._pio + 0x3000] = self._bit  # clears it
        self.taken = self.room - self._dma.count
        self._dma.active(0)

    def print_records(self):
        for at in range(0, 4 * self.taken, 384):
            print(str(b2a_base64(memoryview(self._records)[at : min(at + 384, 4 * self.taken)]), "ascii").strip())
        print("-")
