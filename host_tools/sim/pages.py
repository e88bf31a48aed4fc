"""The raw pages of a virtual board's flash: bytes in memory or in a file, that may be torn by a power cut at any byte.

    pages = Pages(Path("flash/pages"))
    pages.cut_after(1000)       # 1000 bytes more are programmed or erased, then PowerCut

The byte that is torn keeps some of its bits; of a block whose erasure is torn every byte does.
"""

import random

from host_tools.failure import Failure, reason

BLOCK = 4096
RECORD = 32


class PowerCut(Exception):
    """The power is gone: whatever was being written is torn."""


class Pages:
    BLOCKS = 4
    SLOTS = BLOCK // RECORD

    def __init__(self, path=None, data=None):
        """`data`: the bytes of the flash; None: erased."""
        self._path = path
        if path is not None and path.exists():
            data = path.read_bytes()
        self.data = bytearray(data or b"\xff" * (BLOCK * self.BLOCKS))
        self._left = None
        self._random = random.Random(0)  # which bits are torn

    def cut_after(self, count, seed=0):
        """Cut the power after `count` bytes more; `seed` decides which bits of the torn byte are programmed."""
        self._left = count
        self._random = random.Random(seed)

    def read(self, block, slot):
        """Return the record at `slot` of `block`, RECORD bytes."""
        at = block * BLOCK + slot * RECORD
        return bytes(self.data[at : at + RECORD])

    def write(self, block, slot, data):
        """Program `data` at `slot` of `block`: bits go from 1 to 0 only, as in flash. Raises PowerCut."""
        at = block * BLOCK + slot * RECORD
        for offset, byte in enumerate(data):
            self._program_byte(at + offset, self.data[at + offset] & byte)
        self._save_file()

    def erase_block(self, block):
        """Set all bits of a block. Raises PowerCut, and leaves random bits, if the power does not last."""
        first = block * BLOCK
        if self._left is not None and self._left < BLOCK:
            for at in range(first, first + BLOCK):
                self.data[at] |= self._random.getrandbits(8)
            raise PowerCut
        self.spend_power(BLOCK)
        self.data[first : first + BLOCK] = b"\xff" * BLOCK
        self._save_file()

    def spend_power(self, count=1):
        """Program or erase `count` bytes. Raises PowerCut if the power does not last for them."""
        if self._left is not None:
            if self._left < count:
                raise PowerCut
            self._left -= count

    def _program_byte(self, at, byte):
        """Program a byte. A power cut tears it: only some of its bits go to 0, and PowerCut is raised."""
        try:
            self.spend_power()
        except PowerCut:
            self.data[at] &= byte | self._random.getrandbits(8)
            raise
        self.data[at] = byte

    def _save_file(self):
        """Write the pages to their file, if there is one, by way of a second file. Raises Failure."""
        if self._path is not None:
            fresh = self._path.with_suffix(".new")  # a process killed here leaves the old file or the new one
            try:
                fresh.write_bytes(self.data)
                fresh.replace(self._path)
            except OSError as error:
                raise Failure("cannot write {}: {}", self._path, reason(error)) from error
