"""Keeps a text across power cuts: two slots, written in turn, each with its sequence number and checksum.

    journal = Journal(FileSlots("/settings"))
    journal.read()          # the text last written whole; None if there is none
    journal.write(text)

Only the older slot is ever written, and it counts only when its last byte is there and right. A power cut at any byte
of a write therefore leaves what was there before; one after it finds the new text. A slot is

    passo <sequence> <length of the text in bytes> <CRC-32 of all the rest, in hexadecimal>\\n<text>
"""

import gc
import os
from binascii import crc32

from micropython import const

SLOTS = const(2)
_MAGIC = b"passo"


class Journal:
    def __init__(self, slots):
        """`slots`: read(0 or 1) → bytes, b"" where nothing is; write(0 or 1, bytes)."""
        self._slots = slots
        self._slot = 0  # the one that holds the newest text
        self._sequence = None  # not read yet
        self.damaged = False  # read() found slots, and none of them whole

    def read(self):
        """Return the newest text that is whole; None if there is none. `damaged`: there are slots, none of them whole."""
        used, newest = False, None
        self._sequence = 0
        for slot in range(SLOTS):
            data = self._slots.read(slot)
            used = used or len(data) > 0
            sequence, text = _parse_slot(data)
            if text is not None and sequence > self._sequence:
                self._slot, self._sequence, newest = slot, sequence, text
        self.damaged = used and newest is None
        return newest

    def write(self, text):
        """Write `text` into the older slot. Raises OSError if the memory is full or broken; the text stored before is still there then."""
        if self._sequence is None:
            self.read()
        slot, sequence = (self._slot + 1) % SLOTS, self._sequence + 1
        body = text.encode()
        self._slots.write(slot, _front_line(sequence, body) + body)
        self._slot, self._sequence = slot, sequence


def seal_record(front, body=b""):
    """Return the first line of a file: `front`, and the CRC-32 of it and of the `body` behind it."""
    return front + b" %08x\n" % (crc32(body, crc32(front)) & 0xFFFFFFFF)


def _front_line(sequence, body):
    """Return the first line of a slot, with its checksum."""
    return seal_record(b"passo %d %d" % (sequence, len(body)), body)


def _parse_slot(data):
    """Return (sequence, text) of a slot; (0, None) if it is not whole."""
    end = data.find(b"\n")
    fields = data[: max(end, 0)].split(b" ")
    if len(fields) != 4 or fields[0] != _MAGIC:
        return 0, None
    try:
        sequence, length = int(fields[1]), int(fields[2])
        body = data[end + 1 : end + 1 + length]
        if len(body) != length or data[: end + 1] != _front_line(sequence, body):
            return 0, None
        return sequence, body.decode()
    except ValueError:
        return 0, None


class FileSlots:
    """Slots as two files, PATH.0 and PATH.1. A written file leaves much behind; it is collected there and then, the machine
    at rest, and not when something has to stop."""

    def __init__(self, path):
        self._path = path

    def _slot_path(self, slot):
        """Return the path of a slot's file."""
        return "%s.%d" % (self._path, slot)

    def read(self, slot):
        try:
            with open(self._slot_path(slot), "rb") as file:
                return file.read()
        except OSError:
            return b""

    def write(self, slot, data):
        """Write a slot's file whole and sync the file system. Raises OSError."""
        with open(self._slot_path(slot), "wb") as file:
            file.write(data)
        file = None
        gc.collect()
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
