"""The interlock on a chip: edges of pins, filtered, become changes of its inputs, and forbidden outputs go off.

A change counts once it has lasted the input's filter_us. The interrupt waits for that, so on an RP2040 the last step comes at most that
long and 0.12 ms after the edge (test_pico_interlock.py); an input that halts is quicker. A change that does not last is a glitch, and
counted. Two spikes within one such interrupt count as one. A wire that is noisy all the time keeps the main loop from running, not the
feeder and not the player; after 170 ms the feeder slows down to a stand.
"""

from time import ticks_diff, ticks_us

import micropython
from machine import Pin, disable_irq, enable_irq

from passo.options.interlock.port import Interlock
from passo.options.interlock.steps_viper import INTERLOCK_OUTPUTS, INTERLOCK_TOOL, find_ahead, find_denied
from passo.steps.position import Latch


class PinInterlock(Interlock):
    def __init__(self, board, port, inputs, outputs):
        """`inputs`: {name: Input} of the port, `outputs`: {name: (Pin, active level)}."""
        Interlock.__init__(self, board, port)
        tool = board["tool"]
        self._tool = Pin(tool["pin"])
        self._on = tool["active"]
        self._pins = []  # (bit, pin, its level when off)
        bit = INTERLOCK_OUTPUTS
        for entry in board["outputs"]:
            pin, active = outputs[entry["name"]]
            self._pins.append((bit, pin, 1 - active))
            bit <<= 1
        self.watches = {}  # by the inputs' numbers
        self.items = [inputs[entry["name"]] for entry in board["inputs"]]
        self.read(self.read_pins())
        for number in range(len(self.items)):
            if self.watched >> number & 1 and not board["inputs"][number]["halt"] and self.items[number].pin is not None:
                self.watches[number] = PinWatch(self.items[number], number, self, port)

    def read_pins(self):
        """Return the inputs at the pins, a bit each: 1 active."""
        states = 0
        bit = 1
        for item in self.items:
            if item.active():
                states |= bit
            bit <<= 1
        return states

    @micropython.native
    def is_tool_on(self):  # ISR: no allocation
        """Return True while the tool's pin is on."""
        return self._tool.value() == self._on

    @micropython.native
    def put_outputs(self, mask, on):  # ISR: no allocation
        """Switch the outputs of `mask`, INTERLOCK_…: 1 on, 0 off."""
        for bit, pin, off in self._pins:
            if mask & bit:
                pin.value(off ^ on)

    lock = staticmethod(disable_irq)
    unlock = staticmethod(enable_irq)

    def close(self):
        """Switch the interrupts of the inputs off."""
        for item in self.items:
            if item.pin is not None:
                item.pin.irq(None)


class PinWatch(Latch):
    def __init__(self, item, number, interlock, port):
        """Watch `item`, an Input of the port, number `number` of the board file's."""
        Latch.__init__(self)
        rise = bool(interlock.rise >> number & 1)
        fall = bool(interlock.fall >> number & 1)
        # Fetched at once: an attribute costs up to 10 µs.
        self._all = interlock, number, 1 << number, item.level, rise, fall, interlock.filters_us[number], interlock.table
        edges = 0
        if rise:
            edges |= Pin.IRQ_RISING if item.level else Pin.IRQ_FALLING
        if fall:
            edges |= Pin.IRQ_FALLING if item.level else Pin.IRQ_RISING
        port.watch(item.pin, self.on_edge, edges)

    @micropython.native
    def on_edge(self, pin):  # ISR: no allocation
        """Wait until the edge has lasted filter_us; then stop the player if a step that it forbids lies ahead. Called in the pin's interrupt."""
        begun = ticks_us()
        value = pin.value()
        interlock, number, bit, level, rise, fall, filter_us, table = self._all
        active = value == level
        self.hold()
        states = interlock.states
        if active == (states & bit != 0):
            interlock.glitches[number] += 1  # over by now
            return
        if not (rise if active else fall):
            return  # it allows: the main loop sees to it
        # The steps that this is going to forbid, and the player's stop: looked up while the filter's time passes.
        exempt = interlock.exempt
        forbidden = find_denied(table, (states ^ bit) & ~exempt | interlock.fall & exempt) & ~INTERLOCK_TOOL
        playing = interlock.playing
        if playing is not None:
            state, marks, played, halt, hold = playing
        waits = filter_us
        while waits:
            waits = ticks_diff(ticks_us(), begun) < filter_us
            if pin.value() != value:
                interlock.glitches[number] += 1
                return
        if playing is not None and find_ahead(state, marks, played(), forbidden):
            halt()  # the sooner the better; take_change() says why
            hold(True)
        interlock.take_change(number, active)


def create(board, port, inputs, outputs):
    """Return the port's part."""
    return PinInterlock(board, port, inputs, outputs)
