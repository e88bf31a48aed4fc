"""The object being received: points kept as five bytes each, first in, first out, in one block of memory."""

from micropython import const

_POINT = const(5)


class Store:
    """A ring of points (x, y, tool), x and y 0 … 65535 steps."""

    def __init__(self, capacity):
        self.capacity = capacity
        self._bytes = bytearray(_POINT * capacity)
        self._first = 0
        self.count = 0

    def free(self):
        return self.capacity - self.count

    def clear(self):
        self._first = self.count = 0

    def put(self, x, y, tool):
        """Append a point. The caller has seen that free() > 0."""
        at = (self._first + self.count) % self.capacity * _POINT
        data = self._bytes
        data[at] = 1 if tool else 0
        data[at + 1] = x >> 8
        data[at + 2] = x & 255
        data[at + 3] = y >> 8
        data[at + 4] = y & 255
        self.count += 1

    def take(self):
        """The oldest point, as (x, y, tool); it leaves the store."""
        at = self._first * _POINT
        data = self._bytes
        self._first = (self._first + 1) % self.capacity
        self.count -= 1
        return data[at + 1] << 8 | data[at + 2], data[at + 3] << 8 | data[at + 4], data[at] == 1
