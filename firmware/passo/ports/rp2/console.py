"""Takes what the USB console has received in one go: MicroPython gives single bytes, and never says how many there are.

    console = Console()
    console.take(data, 128)     # how many bytes it has put there; 0 until it is proven
    console.taken(value)        # of each byte read, until it is

They lie in a ring buffer of the interpreter, whose record (address, size, where the next byte is read, and written) is found
in memory by its look. It counts only after _PROOFS bytes have been read at that address, one after the other; after the first that
was not it never counts. The address where the next byte is read is then moved on here, as the interpreter does; what writes there moves
the other.
"""

import micropython
from micropython import const

_SIZE = const(512)  # bytes of the buffer: MICROPY_HW_STDIN_BUFFER_LEN of ports/rp2
_WORDS = const(8192)  # of memory that are looked through: its variables come first
_PROOFS = const(12)
# ringbuf_t of py/ringbuf.h: words, and halfwords.
_ADDRESS = const(0)
_EXTENT = const(1)  # the size, and above it where the next byte is read
_WRITTEN = const(2)
_NEXT_READ = const(3)
_NEXT_WRITTEN = const(4)


@micropython.viper
def find() -> int:
    """The record of an empty ring buffer of that size, its distance from the start of memory; 0: there is none, or more
    than one."""
    words = ptr32(0x20000000)
    found = 0
    at = 1
    while at < _WORDS:
        second = words[at + _EXTENT]
        if second & 0xFFFF == _SIZE and words[at + _ADDRESS] >> 20 == 0x200:
            read = second >> 16 & 0xFFFF
            if read < _SIZE and words[at + _WRITTEN] & 0xFFFF == read:
                if found:
                    return 0
                found = 4 * at
        at += 1
    return found


class Console:
    def __init__(self):
        self._at = find()
        self._next = 0  # where the next byte is to be read
        self._left = _PROOFS if self._at else -1  # proofs that are missing; -1: it has failed

    @micropython.viper
    def take(self, data, most: int) -> int:
        """Take at most so many of the bytes that have come. Returns how many; 0 also if that is not known."""
        left = int(self._left)
        if left < 0:
            return 0
        at = 0x20000000 + int(self._at)
        record = ptr16(at)
        here = int(record[_NEXT_READ])
        if left:
            self._next = here
            return 0
        count = (int(record[_NEXT_WRITTEN]) - here) & _SIZE - 1
        if count > most:
            count = most
        ring = ptr8(ptr32(at)[_ADDRESS])
        out = ptr8(data)
        done = 0
        while done < count:
            out[done] = ring[here]
            here = (here + 1) & _SIZE - 1
            done += 1
        record[_NEXT_READ] = here
        return count

    @micropython.viper
    def taken(self, value: int):
        """A byte has been read."""
        left = int(self._left)
        if left < 1:
            return  # bytes beyond the last proof
        at = 0x20000000 + int(self._at)
        here = int(self._next)
        there = int(ptr16(at)[_NEXT_READ])
        if there == (here + 1) & _SIZE - 1 and int(ptr8(ptr32(at)[_ADDRESS])[here]) == value:
            self._next = there
            self._left = left - 1
        else:
            self._left = -1
