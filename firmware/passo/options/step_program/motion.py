"""A step program: a path written down step by step, which can be walked both ways from any index.

    program = StepProgram(3, cells=1024)
    program.clear_items()
    program.append(run(0b011, 0b010, 500))    # 500 times: x a step forward and y a step back at once
    program.append(make_mark(DWELL, 2000))

An item is one integer below 2³⁰. `count << 8 | negative << 4 | mask` is a run of equal single steps: of the axes in
`mask`, those in `negative` backwards. If the mask is 0 it is a mark, `value << 8 | kind << 4`:

    DWELL    stand for `value` milliseconds; walking backward it is skipped
    TOOL     bit 0: the tool from here on; bit 1, which append() adds: the tool up to here
    SPEED    mm/min along the path, from here on
    WAS      mm/min up to here: append() puts one before each SPEED, it is no unit of its own
    STATION  the walk ends here; what for, `value` tells the program's owner; walking backward it is skipped

An *index* is the number of units before it: every single step is one, and every mark. Equal runs are merged.

The items lie in a ring of cells. A closed program is complete. An open one, `ring` set, goes on growing, and forgets its
oldest items when the cells are used up. One producer, the main loop, one reader, which may be an interrupt: a cell is
written before `end` counts it. Cells and indices count modulo 2²⁹.
"""

import micropython
from micropython import const

from passo.arrays import zeros
from passo.records import COUNT_MASK

DWELL = const(1)
TOOL = const(2)
SPEED = const(3)
WAS = const(4)
STATION = const(5)
MOST = const(0x3FFFFF)  # of a count or a value


def run(mask, negative, count=1):
    """Return the item of `count` (1 … MOST) single steps of the axes in `mask`."""
    return count << 8 | negative << 4 | mask


def make_mark(kind, value=0):
    """Return the item of a mark with a value of 0 … MOST."""
    return value << 8 | kind << 4


def count_units(item):
    """Return the number of units of an item."""
    if item & 15:
        return item >> 8
    return 0 if item >> 4 & 15 == WAS else 1


class StepProgram:
    def __init__(self, axes, cells):
        """`cells`: how many items it holds, rounded down to a power of two."""
        size = 1
        while 2 * size <= cells:
            size *= 2
        self.size = size
        self.mask = size - 1
        self.items = zeros(size)  # made in one piece: a board has no second room of this size to copy from
        self.axes = axes
        self.at = [0] * axes  # steps from the start to the end, of each axis
        self.low = [0] * axes  # the farthest it gets
        self.high = [0] * axes
        self.clear_items()

    def clear_items(self, speed=0, ring=False):
        """Forget everything. `speed` (mm/min) is in force at the start; `ring`: the oldest items may be forgotten."""
        self.first = self.end = 0  # cells
        self.start = 0  # index of the first cell
        self.total = 0  # index of the end
        self.speed_before = speed  # in force at the start
        self.speed = speed  # in force at the end
        self.tool = 0
        self.ring = ring
        self.open = ring  # more may come
        for axis in range(self.axes):
            self.at[axis] = self.low[axis] = self.high[axis] = 0

    def expect_more(self, more):
        """Open the program, if `more` items are to come and a walk waits for them; else close it."""
        self.open = more

    def cells_used(self):
        """Return the number of cells in use."""
        return (self.end - self.first) & COUNT_MASK

    def append(self, item):
        """Add an item. False if there is no room: nothing has been added then."""
        if item & 15:
            return self.extend((item,), 0) == 1
        kind = item >> 4 & 15
        if kind == SPEED:
            if not self._make_room(2):
                return False
            self._put_item(make_mark(WAS, self.speed))
            self.speed = item >> 8
        elif not self._make_room(1):
            return False
        if kind == TOOL:
            item |= self.tool << 9
            self.tool = item >> 8 & 1
        self._put_item(item)
        self.total = (self.total + 1) & COUNT_MASK
        return True

    @micropython.native
    def extend(self, new, at):
        """Add the runs that stand in new[at:], up to a mark or to where there is no room; returns where it stopped."""
        items = self.items
        mask = self.mask
        positions = self.at
        low = self.low
        high = self.high
        axes = range(self.axes)
        while at < len(new):
            item = new[at]
            if not item & 15:
                break
            count = item >> 8
            end = self.end
            last = (end - 1) & mask
            before = items[last]
            if not (before ^ item) & 255 and end != self.first and (before >> 8) + count <= MOST:
                items[last] = before + (count << 8)
            elif (end - self.first) & COUNT_MASK <= mask or self._make_room(1):
                items[end & mask] = item
                self.end = (end + 1) & COUNT_MASK
            else:
                break
            self.total = (self.total + count) & COUNT_MASK
            at += 1
            for axis in axes:
                if item >> axis & 1:
                    if item >> axis & 16:
                        position = positions[axis] - count
                        if position < low[axis]:
                            low[axis] = position
                    else:
                        position = positions[axis] + count
                        if position > high[axis]:
                            high[axis] = position
                    positions[axis] = position
        return at

    def _make_room(self, count):
        """Return True if `count` cells are free; a ring forgets its oldest items for that."""
        if self.cells_used() + count <= self.size:
            return True
        if not self.ring:
            return False
        while self.cells_used() + count > self.size:
            self.start = (self.start + count_units(self.items[self.first & self.mask])) & COUNT_MASK
            self.first = (self.first + 1) & COUNT_MASK
        return True

    def _put_item(self, item):
        """Write an item to the next cell."""
        self.items[self.end & self.mask] = item
        self.end = (self.end + 1) & COUNT_MASK

    def cut_off(self, cell, done, index):
        """Forget the items ahead of `index`, which is `done` units into `cell`."""
        if done:
            item = self.items[cell & self.mask]
            if item & 15:
                self.items[cell & self.mask] = done << 8 | item & 255
            cell = (cell + 1) & COUNT_MASK
        self.end = cell
        self.total = index

    def correct_speed(self, cell, speed):
        """Let `speed` be the one in force before the next SPEED from `cell` on: it is known only once the walk has come there."""
        while cell != self.end:
            if self.items[cell & self.mask] >> 4 & 15 == WAS and not self.items[cell & self.mask] & 15:
                self.items[cell & self.mask] = make_mark(WAS, speed)
                return
            cell = (cell + 1) & COUNT_MASK
        self.speed = speed
