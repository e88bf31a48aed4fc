"""The part of littlefs that flash_code.py uses: the places of a file's blocks, and the list of those that are kept.

    blocks = Blocks(rp2.Flash(), count, base)
    mount(Files(vfs.VfsLfs2(blocks), code))     # imports open their modules by code.open(path)

A file's blocks are a list from the last one back: block n begins with the numbers of earlier ones (littlefs DESIGN.md, "CTZ
skip-lists").
"""

from array import array
from struct import unpack

import vfs
from machine import mem32
from micropython import const, kbd_intr

from passo.ports.rp2.fields import FLASH_BLOCK, IOCTL_ERASE

_MARK = const(0x5043)  # ends an .mpy
_END = const(12)  # bytes of the numbers that do
ROW_BYTES = const(10)  # of a function
TEXT_BYTES = const(4)
_CORRUPT = const(-84)  # littlefs looks for another block
_CTRL_C = const(3)
_NOT_FOUND = const(2)
_FOLDER = const(0x4000)
_FILE = const(0x8000)


class Unknown(Exception):
    """Something is not as expected: all stays in RAM."""


class Blocks:
    """The flash as littlefs sees it. Notes which block is read, and keeps the blocks that code runs from."""

    def __init__(self, flash, count, base):
        """`base`: address of the first block."""
        self._flash = flash
        self._base = base
        self._kept = bytearray((count + 7) // 8)
        self.count = count
        self.last = -1  # block read

    def readblocks(self, block, data, offset=0):
        self.last = block
        self._flash.readblocks(block, data, offset)

    def writeblocks(self, block, data, offset=0):
        self._flash.writeblocks(block, data, offset)

    def ioctl(self, request, argument):
        if request == IOCTL_ERASE and self._kept[argument >> 3] >> (argument & 7) & 1:
            return _CORRUPT
        return self._flash.ioctl(request, argument)

    def table(self, file):
        """Read the table that ends an .mpy (host_tools/build/mpy.py). Returns (bytes of the file, bytes before its functions, number and
        offset of its names, bytes of the functions' rows, the rows of functions and texts, the code of a call, the file's last block), or
        None if there is no such table. With 0 bytes before the functions the interpreter has to load the file."""
        self.last = -1
        size = file.seek(0, 2)
        if size < _END:
            return None
        file.seek(size - _END)
        head, names, first, call, count, texts, mark = unpack("<HHBBHHH", file.read(_END))
        last = self.last
        count *= ROW_BYTES
        rows = call + count + TEXT_BYTES * texts
        if mark != _MARK or size < _END + rows:
            return None
        if last < 0:  # it lies beside its name
            return size, 0, 0, 0, b"", b"", 0
        file.seek(size - _END - rows)
        return size, head, names << 16 | first if names else 0, count, file.read(rows - call), file.read(call), last

    def chain(self, size, head):
        """Return the addresses of a file's blocks; they are kept from now on."""
        last = 0  # number of the last one
        room = FLASH_BLOCK
        while size > room:
            last += 1
            room += FLASH_BLOCK - 4
            number = last
            while not number & 1:
                room -= 4
                number >>= 1
        addresses = array("I", bytearray(4 * (last + 1)))
        for number in range(last, -1, -1):
            if not 0 <= head < self.count:
                raise Unknown("a file's list of blocks")
            self._kept[head >> 3] |= 1 << (head & 7)
            addresses[number] = self._base + head * FLASH_BLOCK
            head = mem32[addresses[number]]
        return addresses


def mount(files):
    """Let `files` be the root; Ctrl-C cannot come when there is none."""
    kbd_intr(-1)
    try:
        vfs.umount("/")
        vfs.mount(files, "/")
    finally:
        kbd_intr(_CTRL_C)


class Files:
    """The file system while the app is imported: opens modules through `code`, and knows what there is in /passo without
    asking littlefs three times for each import (2 ms each). All else it passes on."""

    def __init__(self, real, code):
        self._real = real
        self._code = code
        self._stopped = False
        self._folders = {}  # b"passo/motion": b"/arc.mpy/line.mpy/"
        self._list(b"passo")

    def _list(self, folder):  # as bytes: for each new str the interpreter looks through all names, 0.1 ms
        """Keep the names of a folder's files, and of all folders in it, as bytes with / behind each."""
        names = b"/"
        for entry in self._real.ilistdir(folder):
            if entry[1] == _FOLDER:
                self._list(folder + b"/" + entry[0])
            else:
                names += entry[0] + b"/"
        self._folders[folder] = names

    def _has(self, path):
        folder, _, name = path.rpartition(b"/")
        return folder in self._folders and b"/" + name + b"/" in self._folders[folder]

    def mount(self, readonly, make):
        pass

    def umount(self):
        pass

    def __getattr__(self, name):
        return getattr(self._real, name)

    def open(self, path, mode):
        """Open a file: a known module through FlashCode, any other as the file system does. Raises KeyboardInterrupt once after a stop."""
        if self._stopped:
            self._stopped = False
            raise KeyboardInterrupt
        if mode == "rb" and self._has(path.encode()):
            return self._code.open(path)
        return self._real.open(path, mode)

    def stat(self, path):
        """The import takes whatever is raised here for "there is none": Ctrl-C has to wait for open()."""
        try:
            return self._stat(path)
        except KeyboardInterrupt:
            self._stopped = True
            return self._stat(path)

    def _stat(self, path):
        """Return os.stat()'s tuple of a path, from the listed names if they have it. Raises OSError for other paths in passo/."""
        name = path.encode()
        if self._has(name):
            return (_FILE,) + (0,) * 9
        if name in self._folders:
            return (_FOLDER,) + (0,) * 9
        if name.startswith(b"passo/"):
            raise OSError(_NOT_FOUND)
        return self._real.stat(path)
