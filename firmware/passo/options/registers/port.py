"""Inputs and outputs behind shift registers: 74HC165 and 74HC595 on four pins, for slow signals.

    registers = ShiftRegisters(board["registers"])
    registers.exchange()                # ISR: outputs out, inputs in
    registers.inputs >> bit & 1

    clock   165 CLK, 595 SRCLK          latch   165 SH/LD, 595 RCLK
    in      QH of the first 165         out     SER of the first 595

Chips of a kind are chained: SER of a 165 to QH of the next, QH' of a 595 to SER of the next. Pin 100 is bit 0 of the first chip (input
A, output QA), 108 that of the second. A low pulse of latch loads the inputs, its end shows what was shifted out: so all outputs
change at once. Outputs go out when they change, inputs come in with the feeder's interrupt, every 3 ms; at an edge of a pin of
`edges`, to which diodes lead from some of the inputs, they come in at once. An output may show the tool.

An exchange runs with interrupts locked: an interrupt that switches an output off must not find it half done.
"""

from time import ticks_diff, ticks_us

import micropython
from machine import Pin, disable_irq, enable_irq

from passo.records import REGISTER_BIT


class ShiftRegisters:
    """For any chip. One with registers of its own may do better: port_rp2.py."""

    def __init__(self, config, outputs):
        """`outputs`: levels that the outputs begin with, a bit each."""
        self.inputs = 0
        self.outputs = outputs
        self.changes = 0  # how often `inputs` has changed
        self.chips_in = config["inputs"]
        self.chips_out = config["outputs"]
        self._watch = None
        self._tool = None  # the tool's pin, whose level an output shows: see show_tool()
        self._tool_mask = 1 << config["tool"] - REGISTER_BIT if config["tool"] >= 0 else 0
        self.clock = Pin(config["clock"], Pin.OUT, value=0)
        self.latch = Pin(config["latch"], Pin.OUT, value=1)
        self.out = Pin(config["out"], Pin.OUT, value=0)
        self.data = Pin(config["in"], Pin.IN)

    @micropython.native
    def exchange(self):  # ISR: no allocation
        """Show the outputs and read the inputs, with interrupts locked."""
        state = disable_irq()
        if self._tool is not None:
            if self._tool.value():
                self.outputs |= self._tool_mask
            else:
                self.outputs &= ~self._tool_mask
        inputs = self._shift_bits()
        if inputs != self.inputs:
            self.inputs = inputs
            self.changes += 1
        enable_irq(state)

    @micropython.native
    def _shift_bits(self):  # ISR: no allocation
        """Shift `outputs` out and the inputs in. Returns the inputs, a bit each."""
        clock = self.clock
        latch = self.latch
        data = self.data
        out = self.out
        latch.value(0)
        latch.value(1)
        inputs = 0
        bits_in = self.chips_in << 3
        bits_out = self.chips_out << 3
        count = bits_in if bits_in > bits_out else bits_out
        at = 0
        while at < count:
            if at < bits_in:
                inputs |= data.value() << ((at & ~7) + 7 - (at & 7))
            left = count - 1 - at
            out.value(self.outputs >> left & 1 if left < bits_out else 0)
            clock.value(1)
            clock.value(0)
            at += 1
        latch.value(0)
        latch.value(1)
        return inputs

    def input(self, entry):
        """Return the RegisterInput of an entry of the board file."""
        return RegisterInput(entry, self)

    def output(self, entry):
        """Return the RegisterOutput of an entry of the board file."""
        return RegisterOutput(entry, self)

    def begin(self, port, board, mask):
        """Watch the inputs for the interlock: all inputs and outputs are made. `mask`: of the pins of the other inputs."""
        self._tool_pin = board["tool"]["pin"]
        if port.veto is not None:
            self._watch = RegisterWatch(port.veto, self)
            self._watch.watch_edges(port, board["registers"]["edges"], board["inputs"])

    def join(self, feeder, player):
        """Show the tool from here on: the player drives its pin by now."""
        self.show_tool(self._tool_pin)

    def check(self):  # ISR: no allocation
        """Exchange, and look at the inputs. Called in the feeder's interrupt, every 3 ms."""
        self.exchange()
        if self._watch is not None:
            self._watch.look()

    def close(self):
        """Show the outputs for the last time."""
        self.exchange()

    def show_tool(self, number):
        """Show the level of pin `number` on an output from here on, if the board file names one."""
        if self._tool_mask:
            self._tool = Pin(number)

    @micropython.native
    def show_bit(self, bit, level):  # ISR: no allocation
        """Show the level of an output at once."""
        state = disable_irq()
        if level:
            self.outputs |= 1 << bit
        else:
            self.outputs &= ~(1 << bit)
        enable_irq(state)
        self.exchange()


class RegisterInput:
    """As chip_port.Input, for a register's bit."""

    pin = None

    def __init__(self, entry, registers):
        self.number = entry["pin"]
        self.level = entry["active"]
        self._registers = registers
        self._bit = entry["pin"] - REGISTER_BIT

    @micropython.native
    def active(self):  # ISR: no allocation
        """Return True while the input is active."""
        return self._registers.inputs >> self._bit & 1 == self.level


class RegisterOutput:
    """As machine.Pin, for a register's bit."""

    def __init__(self, entry, registers):
        self._registers = registers
        self._bit = entry["pin"] - REGISTER_BIT

    @micropython.native
    def value(self, level):  # ISR: no allocation
        """Show a level."""
        self._registers.show_bit(self._bit, level)


class RegisterWatch:
    """Tells the interlock of inputs behind registers. A change of one with a filter has to show in two readings: those of the feeder's
    interrupt, or the two of an edge's, as far apart as the longest filter of the inputs that have one."""

    def __init__(self, interlock, registers):
        self._interlock = interlock
        self._registers = registers
        self._items = []  # (input, its number, a bit)
        self._filtered = self._pending = 0
        for number in range(len(interlock.items)):
            item = interlock.items[number]
            if item.pin is None and interlock.watched >> number & 1:
                self._items.append((item, number, 1 << number))
                if interlock.filters_us[number]:
                    self._filtered |= 1 << number
        self._inputs = self._states = -1  # as of the last look
        self._wait_us = 0

    def watch_edges(self, port, edges, inputs):
        """Read the registers at once at each edge of these pins. `edges`: the board file's registers.edges, `inputs` its inputs."""
        for entry in edges:
            names = entry["inputs"].split()
            self._wait_us = max([self._wait_us] + [item["filter_us"] for item in inputs if item["name"] in names])
            port.watch(Pin(entry["pin"], Pin.IN), self.on_edge, Pin.IRQ_RISING | Pin.IRQ_FALLING)

    @micropython.native
    def on_edge(self, pin):  # ISR: no allocation
        """Read the registers, and again after the filter's time if a filtered input has changed. Called in the pin's interrupt."""
        registers = self._registers
        registers.exchange()
        self.look()
        if self._pending:
            begun = ticks_us()
            while ticks_diff(ticks_us(), begun) < self._wait_us:
                pass
            registers.exchange()
            self.look()

    @micropython.native
    def look(self):  # ISR: no allocation
        """Tell the interlock of changed inputs. Called behind each exchange: 10 µs without a change, else 0.3 ms for twelve inputs."""
        interlock = self._interlock
        inputs = self._registers.inputs
        if inputs == self._inputs and interlock.states == self._states and not self._pending:
            return
        self._inputs = inputs
        for item, number, bit in self._items:
            active = item.active()
            if active == bool(interlock.states & bit):
                if self._pending & bit:
                    self._pending &= ~bit
                    interlock.glitches[number] += 1
            elif (interlock.rise if active else interlock.fall) & bit:  # the main loop takes changes that allow
                if self._filtered & bit and not self._pending & bit:
                    self._pending |= bit
                else:
                    self._pending &= ~bit
                    interlock.take_change(number, active)
        self._states = interlock.states


def first_levels(board):
    """Return the levels of the outputs behind registers, all off, a bit each."""
    levels = 0
    for entry in board["outputs"]:
        if entry["pin"] >= REGISTER_BIT and not entry["active"]:
            levels |= 1 << entry["pin"] - REGISTER_BIT
    tool = board["registers"]["tool"]
    if tool >= 0 and not board["tool"]["active"]:
        levels |= 1 << tool - REGISTER_BIT
    return levels


def create(board, port, inputs, outputs):
    """Return the port's part."""
    return ShiftRegisters(board["registers"], first_levels(board))
