"""Takes what the USB console has received in one go: MicroPython gives single bytes, and never says how many there are.

    console = Console()
    console.check(value)                # of each byte read, until it returns True
    console.any(ready)                  # from then on
    console.take(data, 640, ready)      # how many bytes it has put there; `ready`: asks the interpreter whether bytes are there
    console.close()                     # give the interpreter its console back

Bytes pass two buffers: TinyUSB's, 256 bytes, from which the interpreter moves them one by one into a ring of its own, 500 to 700 cycles
each. Console finds the records of both in memory by their values. Before it uses them, the first _PROOFS bytes that are read must lie in both buffers
at the expected index. If one does not, bytes are read singly until the board restarts. If find_fifo() finds no buffer of TinyUSB's, because this
MicroPython has another version of it, Console checks and reads the ring alone.

Once both are checked, Console marks the ring as full. The interpreter then leaves the bytes in TinyUSB's buffer, and take() copies them
from there. If TinyUSB's buffer has no room for another packet, the last byte passes through the ring, because TinyUSB then asks the PC for more only
when the interpreter reads. The ring is filled with zeros: if the program ends without close(), the REPL ignores them.

A packet is 64 bytes. Behind the first one and behind each full one take() waits for the next, so that `?` is seen behind the lines that a
sender has under way. The first may have lain here for long while the rest waited in the PC.
"""
# ruff: noqa: F821 (pointers of viper)

from time import sleep_ms, sleep_us

import micropython
from micropython import const

_SIZE = const(512)  # bytes of the ring: MICROPY_HW_STDIN_BUFFER_LEN of ports/rp2
_WORDS = const(8192)  # of memory that are looked through: its variables come first
_PROOFS = const(12)
_ENDPOINT = const(64)  # bytes of a packet on a full-speed bus
_PACKET_US = const(20)  # take() waits this long for the next packet, which takes 53 µs on the bus; copying the last one takes the rest
# ringbuf_t of py/ringbuf.h: words, and halfwords.
_ADDRESS = const(0)
_EXTENT = const(1)  # the size, and above it where the next byte is read
_WRITTEN = const(2)
_NEXT_READ = const(3)
_NEXT_WRITTEN = const(4)
# tu_fifo_t of TinyUSB's common/tusb_fifo.h, that of received bytes in cdc_device.c: words, and halfwords. Its indices count to twice its depth.
_DEPTH = const(256)  # CFG_TUD_CDC_RX_BUFSIZE
_KIND = const(0x10100)  # the depth, and above it the bytes of an item
_AHEAD = const(40)  # bytes from the record to its buffer: it and that of sent bytes
_FIFO_WRITTEN = const(4)
_FIFO_READ = const(5)


@micropython.viper
def find() -> int:
    """Return the record of an empty ring buffer of that size, its distance from the start of memory; 0: there is none, or more
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


@micropython.viper
def find_fifo() -> int:
    """Return the record of TinyUSB's buffer, in the same way."""
    words = ptr32(0x20000000)
    found = 0
    at = 1
    while at < _WORDS:
        if words[at + _EXTENT] == _KIND and words[at + _ADDRESS] == 0x20000000 + 4 * at + _AHEAD:
            if found:
                return 0
            found = 4 * at
        at += 1
    return found


def create(link):
    """Return the Console of the USB port."""
    return Console()


class Console:
    def __init__(self):
        self._at = find()
        self._fifo = find_fifo()  # 0: bytes are taken from the ring
        self._next = 0  # the index of the next byte to read
        self._left = _PROOFS if self._at else -1  # proofs that are missing; -1: it has failed
        self._empty = True  # no byte has been read, so it is not known where the next one will be

    @micropython.viper
    def check(self, value: int) -> bool:
        """Check that a byte that has been read lay where it was expected. Returns True with the last byte that had to be checked: then call take(),
        and no longer the interpreter's read."""
        left = int(self._left)
        if left < 1:
            return False
        at = 0x20000000 + int(self._at)
        record = ptr16(at)
        ring = ptr8(ptr32(at)[_ADDRESS])
        there = int(record[_NEXT_READ])
        behind = (int(record[_NEXT_WRITTEN]) - there) & _SIZE - 1  # bytes that wait there
        fifo = int(self._fifo)
        if self._empty:
            self._empty = False
        elif there != (int(self._next) + 1) & _SIZE - 1:
            left = -1
        self._next = there
        if int(ring[(there - 1) & _SIZE - 1]) != value:
            left = -1
        elif left > 0 and fifo == 0:
            left -= 1
        elif left > 0 and behind < _DEPTH:  # else newer bytes have been written over it
            fifo += 0x20000000
            passed = ptr8(ptr32(fifo)[_ADDRESS])
            left = left - 1 if int(passed[(int(ptr16(fifo)[_FIFO_READ]) - 1 - behind) & _DEPTH - 1]) == value else -1
        if left == 0 and fifo and behind:  # the ring can be marked as full only when it is empty
            left = 1
        self._left = left
        if left or fifo == 0:
            return left == 0
        while left < _SIZE:
            ring[left] = 0
            left += 1
        record[_NEXT_READ] = 0
        record[_NEXT_WRITTEN] = _SIZE - 1
        return True

    @micropython.viper
    def any(self, ready) -> bool:
        """Return True if bytes wait in the ring, after the USB task has had its chance to bring some."""
        if int(self._come()) == 0:
            if self._fifo:
                sleep_ms(0)  # run TinyUSB's task, which takes in the next packet
            else:
                ready(0)  # this also moves bytes to the ring
        return int(self._come()) != 0

    @micropython.viper
    def _come(self) -> int:
        """Return how many bytes wait."""
        at = int(self._fifo)
        if at:
            record = ptr16(0x20000000 + at)
            return (int(record[_FIFO_WRITTEN]) - int(record[_FIFO_READ])) & 2 * _DEPTH - 1
        record = ptr16(0x20000000 + int(self._at))
        return (int(record[_NEXT_WRITTEN]) - int(record[_NEXT_READ])) & _SIZE - 1

    @micropython.viper
    def take(self, data, most: int, ready) -> int:
        """Take the bytes that have come, and those that come meanwhile, at most `most`. Returns how many bytes. One function for this
        and _take_fifo() was tried: points over USB were 7 % slower."""
        sleep_ms(0)
        if int(self._fifo) == 0:
            ready(0)
            return int(self._take_ring(data, most))
        done = 0
        while True:
            count = int(self._take_fifo(data, done, most, ready))
            if count == 0 or count < _ENDPOINT and done:  # the PC has sent no more
                return done + count
            done += count
            sleep_us(_PACKET_US)
            sleep_ms(0)  # run TinyUSB's task, which takes in the next packet

    @micropython.viper
    def _take_fifo(self, data, begin: int, most: int, ready) -> int:
        """Take what lies in TinyUSB's buffer, and put it behind the first `begin` bytes of `data`, which has room for `most`. Returns how many
        bytes; 0 if there might be no room for those that come meanwhile."""
        at = 0x20000000 + int(self._fifo)
        fifo = ptr16(at)
        here = int(fifo[_FIFO_READ])
        count = (int(fifo[_FIFO_WRITTEN]) - here) & 2 * _DEPTH - 1
        if begin + count + 2 * _ENDPOINT > most:
            return 0
        passed = ptr8(ptr32(at)[_ADDRESS])
        out = ptr8(data)
        end = begin + count
        full = count > _DEPTH // 2  # there was no room for another packet, or little more
        if full:
            end -= 1
        while begin < end:
            out[begin] = passed[here & _DEPTH - 1]
            here += 1
            begin += 1
        fifo[_FIFO_READ] = here & 2 * _DEPTH - 1
        if full:
            count += int(self._pass(data, begin, ready)) - 1
        return count

    @micropython.viper
    def _pass(self, data: ptr8, begin: int, ready) -> int:
        """Read the last byte of TinyUSB's buffer through the interpreter's ring: TinyUSB then asks the PC for the next packet. Put this byte, and
        bytes that arrive in the meantime, into `data` from index `begin` on. Returns how many bytes."""
        at = 0x20000000 + int(self._at)
        record = ptr16(at)
        ring = ptr8(ptr32(at)[_ADDRESS])
        record[_NEXT_WRITTEN] = 0  # empty
        ready(0)
        count = int(record[_NEXT_WRITTEN])
        record[_NEXT_WRITTEN] = _SIZE - 1
        if count == 0:  # the interpreter has moved none
            at = 0x20000000 + int(self._fifo)
            fifo = ptr16(at)
            at = int(ptr32(at)[_ADDRESS])
            data[begin] = ptr8(at)[fifo[_FIFO_READ] & _DEPTH - 1]
            fifo[_FIFO_READ] = int(fifo[_FIFO_READ]) + 1 & 2 * _DEPTH - 1
            return 1
        at = 0
        while at < count:
            data[begin] = ring[at]
            begin += 1
            ring[at] = 0
            at += 1
        sleep_ms(0)
        return count

    @micropython.viper
    def _take_ring(self, data, most: int) -> int:
        """Move up to `most` bytes from the ring to `data`. Returns their count."""
        at = 0x20000000 + int(self._at)
        record = ptr16(at)
        ring = ptr8(ptr32(at)[_ADDRESS])
        out = ptr8(data)
        here = int(record[_NEXT_READ])
        count = int(self._come())
        if count > most:
            count = most
        done = 0
        while done < count:
            out[done] = ring[here]
            here = (here + 1) & _SIZE - 1
            done += 1
        record[_NEXT_READ] = here
        return count

    @micropython.viper
    def close(self):
        if int(self._left) == 0 and int(self._fifo):
            ptr16(0x20000000 + int(self._at))[_NEXT_WRITTEN] = 0
            self._left = -1
