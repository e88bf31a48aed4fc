"""Patch: a UART as the PL011 of the RP2040 is.

rp2040py's own raises its transmit interrupt again and again, which hangs `machine.UART`; its bytes take no time, its
receiver knows neither time-out nor errors nor DREQ. Here are 32-byte FIFOs, a shift register that takes a character's
time, interrupts by level, the receive time-out after 32 bit times, overrun and line errors, DREQ both ways.

    uart.on_byte = callback        # the stop bit of a byte has gone out
    uart.feed_byte(value, error)   # a whole character has just arrived: FRAMING, PARITY, BREAK or 0
"""

from collections import deque

from rp2040py.peripherals.uart import RPUART

from host_tools.emulator.cycles import delay_ns

FRAMING, PARITY, BREAK, OVERRUN = 0x100, 0x200, 0x400, 0x800
_DATA, _STATUS, _FLAGS, _LINE, _CONTROL, _LEVELS = 0x00, 0x04, 0x18, 0x2C, 0x30, 0x34
_RAW, _MASKED, _CLEAR, _DMA = 0x3C, 0x40, 0x44, 0x48
_RECEIVE, _TRANSMIT, _TIMEOUT = 1 << 4, 1 << 5, 1 << 6
_FRAMING, _PARITY, _BREAK, _OVERRUN = 1 << 7, 1 << 8, 1 << 9, 1 << 10
_TRIGGERS = (4, 8, 16, 24, 28, 28, 28, 28)
_TIMEOUT_BITS = 32


class Pl011(RPUART):
    def __init__(self, replaced):
        self._ready = False
        super().__init__(replaced.rp2040, replaced.name, replaced.irq, replaced.dreq)
        self.on_byte = replaced.on_byte
        self.overruns = 0  # characters lost because the receive FIFO was full
        clock = self.rp2040.clock
        self._shift_alarm = clock.create_alarm(self._end_shift)
        self._timeout_alarm = clock.create_alarm(self._time_out)
        self._ready = True
        self._clear_state()

    def _clear_state(self):
        self._to_send, self._received, self._shifting = deque(), deque(), None
        self._raised, self._levels, self._dma, self._errors = 0, 0x12, 0, 0
        self._overrun = False

    def reset(self):
        """Reset the UART: FIFOs, registers, alarms and interrupts."""
        super().reset()
        if self._ready:  # the chip resets its blocks while it is being built
            self._shift_alarm.cancel()
            self._timeout_alarm.cancel()
            self._clear_state()
            self.check_interrupts()

    @property
    def _depth(self):
        return 32 if self.fifos_enabled else 1

    @property
    def _bit_ns(self):
        divider = self.baud_divider
        return 16e9 * divider / self.rp2040.clk_peri if divider else 1000.0

    @property
    def _character_ns(self):
        line = self._line_ctrl_register
        bits = 1 + self.word_length + (1 if line & 2 else 0) + (2 if line & 8 else 1)
        return delay_ns(bits * self._bit_ns)

    def check_interrupts(self):
        """Set the interrupt line from raised and masked bits, and both DMA requests from the FIFOs."""
        self.rp2040.set_interrupt(self.irq, bool(self._raised & self._interrupt_mask))
        dma = self.rp2040.dma
        room = self._dma & 2 and self.enabled and len(self._to_send) < self._depth
        (dma.set_dreq if room else dma.clear_dreq)(self.dreq.tx)
        waiting = self._dma & 1 and self.enabled and self._received
        (dma.set_dreq if waiting else dma.clear_dreq)(self.dreq.rx)

    def _transmit_trigger(self):
        return _TRIGGERS[self._levels & 7] if self.fifos_enabled else 0

    def _receive_trigger(self):
        return _TRIGGERS[self._levels >> 3 & 7] if self.fifos_enabled else 1

    def _send_next(self):
        """Begin to shift out the next byte if none is under way and the transmitter is on; raise the transmit interrupt as the FIFO falls to its
        level."""
        if self._shifting is None and self._to_send and self.enabled and self.tx_enabled:
            before = len(self._to_send)
            self._shifting = self._to_send.popleft()
            if before > self._transmit_trigger() >= len(self._to_send):
                self._raised |= _TRANSMIT
            self._shift_alarm.schedule(self._character_ns)

    def _end_shift(self):
        """Hand on the byte whose stop bit has gone out, also to the receiver in loop-back, and begin the next."""
        value, self._shifting = self._shifting, None
        if self._ctrl_register & 0x80:  # loop back
            self.feed_byte(value)
        if self.on_byte:
            self.on_byte(value)
        self._send_next()
        self.check_interrupts()

    def feed_byte(self, value, error=0):
        """Receive a character; `error`: FRAMING, PARITY or BREAK. A full FIFO drops it and counts an overrun."""
        if not (self.enabled and self.rx_enabled):
            return
        if len(self._received) >= self._depth:
            self._overrun = True
            self.overruns += 1
            self._raised |= _OVERRUN
        else:
            self._received.append(value & 0xFF | error | (OVERRUN if self._overrun else 0))
            self._overrun = False
            for mark, interrupt in ((FRAMING, _FRAMING), (PARITY, _PARITY), (BREAK, _BREAK)):
                if error & mark:
                    self._raised |= interrupt
            if len(self._received) >= self._receive_trigger():
                self._raised |= _RECEIVE
        self._timeout_alarm.schedule(delay_ns(self._bit_ns * _TIMEOUT_BITS))
        self.check_interrupts()

    def _time_out(self):
        if self._received:
            self._raised |= _TIMEOUT
            self.check_interrupts()

    def _read_data(self):
        """Return the next received byte, its error bits above it, 0 if the FIFO is empty; clears the receive and time-out interrupts that no longer
        hold."""
        value = self._received.popleft() if self._received else 0
        self._errors = value >> 8
        if len(self._received) < self._receive_trigger():
            self._raised &= ~_RECEIVE
        if self._received:
            self._timeout_alarm.schedule(delay_ns(self._bit_ns * _TIMEOUT_BITS))
        else:
            self._raised &= ~_TIMEOUT
            self._timeout_alarm.cancel()
        self.check_interrupts()
        return value

    def _flag_register(self):
        """Return UARTFR: 0x80 transmit FIFO empty, 0x40 receive FIFO full, 0x20 transmit FIFO full, 0x10 receive FIFO empty, 0x08 busy."""
        sending, received, depth = len(self._to_send), len(self._received), self._depth
        return (
            (0x80 if not sending else 0)
            | (0x40 if received >= depth else 0)
            | (0x20 if sending >= depth else 0)
            | (0x10 if not received else 0)
            | (0x08 if sending or self._shifting is not None else 0)
        )

    def read_uint32(self, offset):
        """Return the value of a PL011 register, as the RP2040 has it."""
        if offset == _DATA:
            return self._read_data()
        if offset == _FLAGS:
            return self._flag_register()
        if offset == _STATUS:
            return self._errors
        if offset == _LEVELS:
            return self._levels
        if offset == _RAW:
            return self._raised
        if offset == _MASKED:
            return self._raised & self._interrupt_mask
        if offset == _CLEAR:
            return 0
        if offset == _DMA:
            return self._dma
        return super().read_uint32(offset)

    def write_uint32(self, offset, value):
        """Write a PL011 register. A byte for a full FIFO is lost; a change of the FIFOs' enable bit empties both."""
        if offset == _DATA:
            if len(self._to_send) < self._depth:
                self._to_send.append(value & 0xFF)
            if len(self._to_send) > self._transmit_trigger():
                self._raised &= ~_TRANSMIT
            self._send_next()
            self.check_interrupts()
        elif offset == _STATUS:
            self._errors = 0
        elif offset == _CONTROL:
            self._ctrl_register = value
            self._send_next()
            self.check_interrupts()
        elif offset == _LINE:
            if (value ^ self._line_ctrl_register) & 0x10:  # the FIFOs' enable bit empties them
                self._received.clear()
                self._to_send.clear()
            self._line_ctrl_register = value
        elif offset == _LEVELS:
            self._levels = value & 0x3F
        elif offset == _CLEAR:
            self._raised &= ~self.raw_write_value
            self.check_interrupts()
        elif offset == _DMA:
            self._dma = value & 7
            self.check_interrupts()
        else:
            super().write_uint32(offset, value)
