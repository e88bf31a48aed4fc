"""The bytes that come on a UART while flash is erased or written, all interrupts off for up to 0.4 s: DMA keeps 576 of them.

    capture = Capture(0)            # of UART 0
    before = capture.begin(uart)    # so many bytes, which are in the UART's buffer now, come first
    count = capture.end()           # capture.view[:count] comes behind them

A FIFO alone has 32, at 115 200 baud those of 2.8 ms: a page of flash takes up to 3.
"""

import rp2
from machine import disable_irq, enable_irq, mem32
from micropython import const
from uctypes import addressof

from passo.ports.rp2 import chip

_BYTES = const(576)  # the most that a sender that counts has on its way, and some questions


def create(link):
    """Return the Capture of a link's UART."""
    return Capture(int(link["port"][4:]))


class Capture:
    def __init__(self, number):
        self._data = chip.UART1 if number else chip.UART0
        self.view = memoryview(bytearray(_BYTES))
        self._dma = dma = rp2.DMA()
        self._write_address = 0x50000000 + 0x40 * dma.channel + 4
        self._ctrl = dma.pack_ctrl(size=0, inc_read=False, inc_write=True, treq_sel=chip.UART0_REQUEST + 2 * number)

    def begin(self, uart):
        state = disable_irq()
        before = uart.any()
        self._dma.config(read=self._data, write=self.view, count=_BYTES, ctrl=self._ctrl, trigger=True)
        enable_irq(state)
        return before

    def end(self):
        """Stop the DMA and return the count of bytes in `view`."""
        dma = self._dma
        state = disable_irq()
        dma.active(0)
        count = mem32[self._write_address] - addressof(self.view)
        enable_irq(state)
        return count

    def close(self):
        self._dma.close()
