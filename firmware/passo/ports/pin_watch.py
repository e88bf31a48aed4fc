"""A pin of the interlock on a chip: its edges, filtered, become changes of the interlock's inputs.

A change counts once it has lasted the input's filter_us; the interrupt waits for that, so that a true change acts that long,
and some 30 µs, after its edge. What does not last is a glitch, and counted. Two spikes within one such interrupt count as
one. A wire that is noisy all the time keeps the main loop from running, not the feeder and not the player; after 170 ms the
feeder slows down to a stand.
"""

from time import ticks_diff, ticks_us

import micropython
from machine import Pin


class PinWatch:
    def __init__(self, item, number, interlock, port):
        """Watch `item`, an Input of the port, number `number` of the board file's."""
        self._pin = item
        self._number = number
        self._bit = 1 << number
        self._interlock = interlock
        self._filter_us = interlock.filters_us[number]
        self._rise = bool(interlock.rise >> number & 1)
        self._fall = bool(interlock.fall >> number & 1)
        edges = 0
        if self._rise:
            edges |= Pin.IRQ_RISING if item.level else Pin.IRQ_FALLING
        if self._fall:
            edges |= Pin.IRQ_FALLING if item.level else Pin.IRQ_RISING
        port.watch(item.pin, self.edge, edges)

    @micropython.native
    def edge(self, pin):  # ISR: no allocation
        interlock = self._interlock
        level = self._pin.level
        value = pin.value()
        active = value == level
        number = self._number
        if active == bool(interlock.states & self._bit):
            interlock.glitches[number] += 1  # over by now
            return
        if not (self._rise if active else self._fall):
            return  # it allows: the main loop sees to it
        if self._filter_us:
            begun = ticks_us()
            while ticks_diff(ticks_us(), begun) < self._filter_us:
                if pin.value() != value:
                    interlock.glitches[number] += 1
                    return
        interlock.change(number, active)
