"""Raw pages of the flash, for the job's journal: files of one block each, whose blocks are written past the file system.

littlefs keeps the data of a file of 513 to 4096 bytes in one block of its own, without a header, and never moves or reads it unless
the file is opened. Three arguments of rp2.Flash.writeblocks program without an erase.
"""

import os

import rp2
import vfs

from passo.ports.rp2.fields import FLASH_BLOCK, FLASH_PAGE, IOCTL_ERASE
from passo.records import JOURNAL_BYTES

_NAME = "journal.%d"


def has_file(number):
    """Return True if the file of block `number` is there, whole."""
    try:
        return os.stat(_NAME % number)[6] == FLASH_BLOCK
    except OSError:
        return False


class _Watched:
    """The flash as littlefs sees it, which notes the block that it has read last."""

    def __init__(self, flash):
        self.ioctl = flash.ioctl
        self.writeblocks = flash.writeblocks
        self._flash = flash
        self.last = -1

    def readblocks(self, block, data, offset=0):
        self.last = block
        self._flash.readblocks(block, data, offset)


class Pages:
    """Each block is a file. Its first erase makes it, in 70 ms, after the board's first answer."""

    BLOCKS = 4
    SLOTS = 128

    def __init__(self):
        self._flash = rp2.Flash()
        self._page = bytearray(b"\xff" * FLASH_PAGE)
        self._view = memoryview(self._page)
        self._record = bytearray(JOURNAL_BYTES)
        self._numbers = [-1] * self.BLOCKS  # of their blocks; −1: there is no such file yet
        self._find_blocks()

    def make_files(self):
        """Make all files that are not there yet. Raises OSError."""
        for number in range(self.BLOCKS):
            if not has_file(number):
                self._make_file(number)
        self._find_blocks()

    def _make_file(self, number):
        """Make the file of a block, erased, in 70 ms. Raises OSError."""
        with open(_NAME % number, "wb") as file:
            for _ in range(FLASH_BLOCK // FLASH_PAGE):
                file.write(self._page)
        os.sync()

    def _find_blocks(self):
        """Find the flash blocks of the files: littlefs reads the last byte of each."""
        blocks = _Watched(self._flash)
        files = vfs.VfsLfs2(blocks, readsize=JOURNAL_BYTES)
        for number in range(self.BLOCKS):
            if has_file(number):
                with files.open(_NAME % number, "rb") as file:
                    file.seek(FLASH_BLOCK - 1)
                    file.read(1)
                    self._numbers[number] = blocks.last

    def read(self, block, slot):
        """Return the 32 bytes of a slot, good until the next call; b"" if there is no such file yet."""
        if self._numbers[block] < 0:
            return b""
        self._flash.readblocks(self._numbers[block], self._record, slot * JOURNAL_BYTES)
        return self._record

    def write(self, block, slot, data):
        """Program an erased slot: the rest of its page stays as it is, because ones change nothing."""
        at = slot * JOURNAL_BYTES % FLASH_PAGE
        self._view[at : at + JOURNAL_BYTES] = data
        self._flash.writeblocks(self._numbers[block], self._page, slot * JOURNAL_BYTES - at)
        self._view[at : at + JOURNAL_BYTES] = b"\xff" * JOURNAL_BYTES

    def erase_block(self, block):
        """Erase a block, or make its file. Raises OSError if there is no room for it, MemoryError."""
        if self._numbers[block] < 0:
            self._make_file(block)
            self._find_blocks()
        else:
            self._flash.ioctl(IOCTL_ERASE, self._numbers[block])


def create(board, port, inputs, outputs):
    """Return the port's part."""
    return Pages()
