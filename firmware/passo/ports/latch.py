"""Where the axes stood as an input became active: caught in its interrupt, not when the main loop looks.

    latch = port.latches["limit_x"]
    latch.arm()                 # from here on
    latch.caught, latch.position   # True once it has happened; the position of each axis then, as the feeder counts

An interrupt of the feeder may be in the way, up to 1 ms: of steps further apart than that the position is exact.
"""

from array import array

import micropython

from passo.steps.following_viper import Follower


class Latch:
    def __init__(self, axes):
        self.position = array("i", [0] * axes)
        self.caught = True
        self._follower = self._player = None

    def join(self, feeder, player):
        self._follower = Follower(feeder)
        self._player = player

    def arm(self):
        self.caught = False

    @micropython.native
    def catch(self):  # ISR: no allocation
        if not self.caught and self._player is not None:
            self._follower.find(self._player.played(), self.position)
            self.caught = True


class PinLatch(Latch):
    def __init__(self, axes, item, port, watch, rising, falling):
        """`item`: an Input of the port; `watch`: the interlock's PinWatch of it, which calls catch(), or None."""
        Latch.__init__(self, axes)
        self._item = item
        if watch is not None:
            watch.latch = self
        else:
            port.watch(item.pin, self._edge, rising if item.level else falling)

    @micropython.native
    def _edge(self, pin):  # ISR: no allocation
        self.catch()


class VirtualLatch(Latch):
    def __init__(self, axes, name, level, world):
        Latch.__init__(self, axes)
        self._name = name
        self._level = level
        world.listen(self._changed)

    def _changed(self, tick, name, level):
        if name == self._name and level == self._level:
            self.catch()


def named(board):
    """Names of the inputs that homing wants latched: none that halts, which has an interrupt of its own."""
    homing = board["homing"]
    if not homing or not homing["latch"]:
        return []
    names = list(homing["sensors"].values())
    if board["gantry"] and board["gantry"]["sensor"]:
        names.append(board["gantry"]["sensor"])
    return [item["name"] for item in board["inputs"] if item["name"] in names and not item["halt"]]


def make(board, port, inputs):
    """{name: PinLatch} for the port of a chip; `inputs`: its {name: Input}."""
    from machine import Pin

    latches = {}
    numbers = [item["name"] for item in board["inputs"]]
    for name in named(board):
        watch = port.interlock.watches.get(numbers.index(name)) if port.interlock is not None else None
        latches[name] = PinLatch(len(board["axes"]), inputs[name], port, watch, Pin.IRQ_RISING, Pin.IRQ_FALLING)
    return latches
