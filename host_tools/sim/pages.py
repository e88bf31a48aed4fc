"""The raw pages of a virtual board's flash: bytes in memory or in a file, that may be torn by a power cut at any byte.

    pages = Pages(Path("flash/pages"))
    pages.cut_after(1000)       # so many bytes more are programmed or erased, then PowerCut
"""

BLOCK = 4096
RECORD = 32


class PowerCut(Exception):
    """The power is gone: whatever was being written is torn."""


class Pages:
    BLOCKS = 4
    SLOTS = BLOCK // RECORD

    def __init__(self, path=None, data=None):
        """`data`: what the flash holds, None: it is erased."""
        self._path = path
        if path is not None and path.exists():
            data = path.read_bytes()
        self.data = bytearray(data or b"\xff" * (BLOCK * self.BLOCKS))
        self._left = None

    def cut_after(self, count):
        self._left = count

    def read(self, block, slot):
        at = block * BLOCK + slot * RECORD
        return bytes(self.data[at : at + RECORD])

    def write(self, block, slot, data):
        at = block * BLOCK + slot * RECORD
        for offset, byte in enumerate(data):
            self._put(at + offset, self.data[at + offset] & byte)
        self._save()

    def erase(self, block):
        for at in range(block * BLOCK, (block + 1) * BLOCK):
            self._put(at, 255)
        self._save()

    def _put(self, at, byte):
        if self._left is not None:
            if not self._left:
                raise PowerCut
            self._left -= 1
        self.data[at] = byte

    def _save(self):
        if self._path is not None:
            self._path.write_bytes(self.data)
