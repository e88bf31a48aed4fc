"""Keeps a text across power cuts: two slots, written in turn, each with its sequence number and checksum.

    journal = Journal(FileSlots("/settings"))
    journal.read()          # the text last written whole; None if there is none
    journal.write(text)

Only the older slot is ever written, and it counts only when its last byte is there and right. A power cut at any byte
of a write therefore leaves what was there before; one after it finds the new text. A slot is

    passo <sequence> <length of the text in bytes> <CRC-32 of all the rest, in hexadecimal>\\n<text>
"""

import os
from binascii import crc32

from micropython import const

SLOTS = const(2)
_FILE = const(1200)
_MAGIC = b"passo"


class Journal:
    def __init__(self, slots):
        """`slots`: read(0 or 1) → bytes, b"" where nothing is; write(0 or 1, bytes)."""
        self._slots = slots
        self.damaged = False  # read() found slots, and none of them whole

    def read(self):
        _, _, text = self._newest()
        return text

    def write(self, text):
        """Raises OSError where the memory is full or broken; what was there before is still there then."""
        slot, sequence, _ = self._newest()
        body = text.encode()
        self._slots.write((slot + 1) % SLOTS, _front(sequence + 1, body) + body)

    def _newest(self):
        """(slot, sequence, text) of the newest slot that is whole; (0, 0, None) if there is none."""
        best = (0, 0, None)
        used = False
        for slot in range(SLOTS):
            data = self._slots.read(slot)
            used = used or len(data) > 0
            sequence, text = _parse(data)
            if text is not None and sequence > best[1]:
                best = (slot, sequence, text)
        self.damaged = used and best[2] is None
        return best


def _front(sequence, body):
    front = ("passo %d %d" % (sequence, len(body))).encode()
    return front + (" %08x\n" % (crc32(body, crc32(front)) & 0xFFFFFFFF)).encode()


def _parse(data):
    """(sequence, text) of a slot; (0, None) where it is not whole."""
    end = data.find(b"\n")
    fields = data[: max(end, 0)].split(b" ")
    if len(fields) != 4 or fields[0] != _MAGIC:
        return 0, None
    try:
        sequence, length = int(fields[1]), int(fields[2])
        body = data[end + 1 : end + 1 + length]
        if len(body) != length or data[: end + 1] != _front(sequence, body):
            return 0, None
        return sequence, body.decode()
    except ValueError:
        return 0, None


class FileSlots:
    """Slots as two files, PATH.0 and PATH.1. An open file takes 1148 bytes in one piece on an RP2040, which a board that has
    run for a while may not have: they are kept for it."""

    def __init__(self, path):
        self._path = path
        self._keep()

    def _keep(self):
        try:
            self._kept = bytearray(_FILE)
        except MemoryError:
            pass  # it is asked for again at the next file

    def _open(self, slot, mode):
        self._kept = None
        return open("%s.%d" % (self._path, slot), mode)

    def read(self, slot):
        try:
            with self._open(slot, "rb") as file:
                return file.read()
        except OSError:
            return b""
        finally:
            self._keep()

    def write(self, slot, data):
        try:
            with self._open(slot, "wb") as file:
                file.write(data)
        finally:
            self._keep()
        if hasattr(os, "sync"):
            os.sync()


class MemorySlots:
    """Slots that last as long as the object: for tests, and where nothing is to be kept."""

    def __init__(self):
        self.data = [b"", b""]

    def read(self, slot):
        return self.data[slot]

    def write(self, slot, data):
        self.data[slot] = data
