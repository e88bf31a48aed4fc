"""Moves functions in compiled modules (.mpy) so that they can run in place, from a board's flash, and lists them.

    data = in_place(Path("planner.mpy").read_bytes(), native=False)

A board's littlefs keeps a file in blocks of 4096 bytes; block n > 0 begins with ctz(n) + 1 pointers. Code that lies
within one block can run from flash (firmware/passo/ports/rp2/flash_code.py). `in_place` moves functions that would cross a
block, and native code that is not aligned, by inserting 0x80 bytes before the number that begins them, which do not change its
value. It appends a table of all functions, which the interpreter does not read:

    each function, in the file's order: offset u16, length u16, kind u8 (0: stays in RAM), children u8, functions in its tree u16
    number of functions u16, 0x5043

Format: MicroPython's py/persistentcode.c, .mpy version 6.
"""

import struct

BLOCK_BYTES = 4096
INLINE_BYTES = 512  # littlefs keeps files up to this size beside their names
MARK = 0x5043
_WORTH = 100  # bytes of code for which a small file is given a block
BYTECODE, NATIVE, VIPER, ASSEMBLER = 2, 3, 4, 5
STAYS = 0
_RELOCATED, _RODATA, _BSS = 0x10, 0x20, 0x40  # scope flags of viper code
_TUPLE, _CONSTANTS = 10, (0, 1, 2, 3, 4)  # objects: a tuple; those without a length
_HEADER_BYTES = 4


class Function:
    def __init__(self, begin, offset, length, kind):
        self.begin = begin  # of the number before the code
        self.offset = offset
        self.length = length
        self.kind = kind
        self.children = 0
        self.tree = 1


class _Reader:
    def __init__(self, data):
        self.data = data
        self.at = 0

    def number(self):
        value = 0
        while True:
            byte = self.data[self.at]
            self.at += 1
            value = value << 7 | byte & 0x7F
            if not byte & 0x80:
                return value

    def name(self):
        length = self.number()
        if not length & 1:  # otherwise one of the interpreter's own
            self.at += (length >> 1) + 1

    def object(self):
        kind = self.data[self.at]
        self.at += 1
        if kind in _CONSTANTS:
            return
        length = self.number()
        if kind == _TUPLE:
            for _ in range(length):
                self.object()
        else:
            self.at += length + (kind in (5, 6))  # texts and bytes end with a zero

    def function(self, found):
        begin = self.at
        number = self.number()
        function = Function(begin, self.at, number >> 3, (number & 3) + BYTECODE)
        found.append(function)
        first = len(found)
        self.at += function.length
        self._native(function.kind)
        if number & 4:
            function.children = self.number()
            for _ in range(function.children):
                self.function(found)
        function.tree = len(found) - first + 1

    def _native(self, kind):
        if kind == BYTECODE:
            return
        flags = self.number()  # NATIVE: where its prelude begins
        if kind == ASSEMBLER:
            self.number(), self.number()
        elif kind == VIPER:
            if flags & _RELOCATED:
                raise ValueError("native code that is relocated")
            constants = self.number() if flags & _RODATA else 0
            if flags & _BSS:
                self.number()
            self.at += constants


def functions(data):
    """The functions of an .mpy, outer ones first. Raises ValueError if it is not of version 6."""
    if data[:2] != b"M\x06":
        raise ValueError("no .mpy of version 6")
    reader = _Reader(data)
    reader.at = _HEADER_BYTES
    names, objects = reader.number(), reader.number()
    for _ in range(names):
        reader.name()
    for _ in range(objects):
        reader.object()
    found = []
    reader.function(found)
    return found, reader.at


def block_starts(size):
    """Offsets in the file at which its blocks begin, and how many bytes of pointers stand before each."""
    starts, pointers = [0], [0]
    while starts[-1] < size:
        number = len(starts)
        starts.append(starts[-1] + BLOCK_BYTES - pointers[-1])
        pointers.append(4 * ((number & -number).bit_length()))
    return starts, pointers


def padding(function, offset, native):
    """How many bytes to move a function that would begin at `offset`."""
    moved = -offset % 4 if function.kind != BYTECODE and native else 0
    starts, pointers = block_starts(offset + moved + function.length + BLOCK_BYTES)
    for begin, end in zip(starts, starts[1:]):
        if begin <= offset + moved < end and offset + moved + function.length > end:
            following = BLOCK_BYTES - pointers[starts.index(end)]
            if function.length <= following:  # blocks begin at multiples of four
                moved = end - offset
    return moved


def in_place(data, native=False):
    """The .mpy with its functions moved and the table appended. `native`: viper and native code run in place, too. Raises
    ValueError if the table cannot hold a function."""
    found, end = functions(data)
    out, copied, table = bytearray(), 0, bytearray()
    small = max(0, INLINE_BYTES + 1 - len(data)) if sum(function.length for function in found[1:]) >= _WORTH else 0
    for function in found:
        movable = function.kind == VIPER or function.kind == NATIVE and not function.children
        stays = function.kind != BYTECODE and not (native and movable)
        out += data[copied : function.begin]
        head = function.offset - function.begin
        if not stays:
            out += b"\x80" * small  # so that the file has a block of its own
            small = 0
            out += b"\x80" * padding(function, len(out) + head, native)
        out += data[function.begin : function.offset]
        copied = function.offset
        if len(out) >= 1 << 16 or function.children > 255:
            raise ValueError("more than 64 kB, or than 255 functions in one")
        kind = STAYS if stays else function.kind
        table += struct.pack("<HHBBH", len(out), function.length, kind, function.children, function.tree)
    out += data[copied:end]
    return bytes(out + table + struct.pack("<HH", len(found), MARK))
