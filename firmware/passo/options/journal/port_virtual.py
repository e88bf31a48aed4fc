"""The journal's pages on the virtual port: in memory."""

from passo.records import JOURNAL_BYTES


class MemoryPages:
    """The flash of the job's journal, as port_rp2.py."""

    BLOCKS = 4
    SLOTS = 128

    def __init__(self):
        self._slots = {}

    def read(self, block, slot):
        """See Pages.read()."""
        return self._slots.get((block, slot), b"\xff" * JOURNAL_BYTES)

    def write(self, block, slot, data):
        """See Pages.write()."""
        self._slots[block, slot] = bytes(data)

    def erase_block(self, block):
        """See Pages.erase_block()."""
        for slot in range(self.SLOTS):
            self._slots.pop((block, slot), None)


def create(board, port, world):
    """Return the port's part."""
    return MemoryPages()
