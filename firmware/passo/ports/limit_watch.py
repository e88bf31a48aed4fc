"""Limits of a board without an interlock: the pin's interrupt stops the player, not the main loop's next look; it is homing's latch, too.

    watch = port.watch_limit("limit_x", filter_us)  # None: its pin has no interrupt
    watch.turn(1)               # its level at the pin while it is active: the settings may turn it round
    watch.arm(True)             # from here on; once it has stopped the player it is not, until it is armed anew

A change counts once it has lasted `filter_us`; the interrupt waits for that.
"""

from time import ticks_diff, ticks_us

import micropython
from machine import Pin

from passo.steps.position import Latch


class LimitWatch(Latch):
    def __init__(self, item, filter_us, port):
        """`item`: an Input of the port."""
        Latch.__init__(self)
        self.name = item.name
        self.armed = False
        self.level = item.level
        self._filter_us = filter_us
        self._port = port
        port.watch(item.pin, self._edge, Pin.IRQ_RISING | Pin.IRQ_FALLING)

    def turn(self, level):
        self.level = level

    def arm(self, on):
        self.armed = on

    @micropython.native
    def _edge(self, pin):  # ISR: no allocation
        """Trip if the switch is active for `filter_us`, once while armed. Called in the pin's interrupt."""
        self.hold()
        level = self.level
        if self.armed and pin.value() == level:
            begun = ticks_us()
            while ticks_diff(ticks_us(), begun) < self._filter_us:
                if pin.value() != level:
                    return
            self.armed = False
            self._port.trip(self)
