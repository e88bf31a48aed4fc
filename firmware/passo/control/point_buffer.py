"""The object being received: points kept as five bytes each, first in, first out. Memory is taken as it is needed."""

from micropython import const

from passo.batch import POINT_BYTES

_CHUNK = const(256)  # points of one piece of memory: a board rarely has room for all in one


class PointBuffer:
    """A ring of points (x, y, tool), x and y 0 … 65535 steps. `capacity`: how many at most."""

    def __init__(self, capacity):
        self.capacity = capacity
        self.clear()

    def clear(self):
        """Forget all points, and give back their memory."""
        self._chunks = [None] * ((self.capacity + _CHUNK - 1) // _CHUNK)
        self._size = _CHUNK * len(self._chunks)
        self._first = self.count = 0
        self._spare = None  # a chunk whose points have all been taken: the next one that is wanted

    def free(self):
        """Return how many more points there is room for; 0 also when no memory is left for the next one."""
        if self.count < self.capacity:
            try:
                self._chunk_at((self._first + self.count) % self._size)
            except MemoryError:
                return 0
        return self.capacity - self.count

    def _chunk_at(self, index):
        """Return the chunk of point `index`, made if needed. Raises MemoryError."""
        chunk = self._chunks[index // _CHUNK]
        if chunk is None:
            chunk = self._chunks[index // _CHUNK] = self._spare or bytearray(POINT_BYTES * _CHUNK)
            self._spare = None
        return chunk

    def put(self, x, y, tool):
        """Append a point. The caller has seen that free() > 0."""
        index = (self._first + self.count) % self._size
        data = self._chunk_at(index)
        at = index % _CHUNK * POINT_BYTES
        data[at] = 1 if tool else 0
        data[at + 1] = x >> 8
        data[at + 2] = x & 255
        data[at + 3] = y >> 8
        data[at + 4] = y & 255
        self.count += 1

    def free_rows(self):
        """Return (bytes, the first of them, points) that the next points may be put into, five bytes each: tool 0 or 1, x and y,
        high byte first; `count` is to be raised by how many they were. None if there is no room."""
        room = self.capacity - self.count
        if not room:
            return None
        index = (self._first + self.count) % self._size
        at = index % _CHUNK
        try:
            return self._chunk_at(index), POINT_BYTES * at, min(room, _CHUNK - at)
        except MemoryError:
            return None

    def take(self):
        """Remove and return the oldest point, (x, y, tool). The caller has seen that `count` > 0."""
        data = self._chunk_at(self._first)
        at = self._first % _CHUNK * POINT_BYTES
        self._first = (self._first + 1) % self._size
        self.count -= 1
        if not self._first % _CHUNK and self._spare is None and self.count < self._size - _CHUNK:  # else the newest points lie there
            left = (self._first or self._size) // _CHUNK - 1
            self._spare = self._chunks[left]
            self._chunks[left] = None
        return data[at + 1] << 8 | data[at + 2], data[at + 3] << 8 | data[at + 4], data[at] == 1
