"""Moves functions in compiled modules (.mpy) so that they can run in place, from a board's flash, and lists them.

    data = in_place(Path("planner.mpy").read_bytes(), native=False)

A board's littlefs keeps a file in blocks of 4096 bytes; block n > 0 begins with ctz(n) + 1 pointers. Code that lies
within one block can run from flash (firmware/passo/ports/rp2/stock/flash_code.py). `in_place` moves functions that would cross a
block, and native code that is not aligned, by inserting 0x80 bytes before the number that begins them, which do not change its
value. It appends a table of all functions, which the interpreter does not read:

    each function, in the file's order: start u16, length u16, prelude u16, block u8, kind u8, children u8, 1 if a generator u8
    each text among the constants: start u16, block u8, its number u8
    a function in bytecode that calls _load()(), a name that is added to the file's
    bytes before the first function u16, names among them u16 (0: in more than a block), where these begin u8, bytes of that call
    u8, number of functions u16, of texts u16, 0x5043

`start` is in the block of that number; of block 255 in the file: the function is copied into memory, because it crosses a block, or
is machine code. Without functions there: the interpreter loads the file.

Format: MicroPython's py/persistentcode.c, .mpy version 6.
"""

import struct
from collections import namedtuple

BLOCK_BYTES = 4096
INLINE_BYTES = 512  # littlefs keeps files up to this size beside their names
MARK = 0x5043
_WORTH = 100  # bytes of code for which a small file is given a block
BYTECODE, NATIVE, VIPER = 2, 3, 4
_ROW, _TEXT, _END, _MEMORY = "<HHHBBBB", "<HBB", "<HHBBHHH", 255
_CALLED = b"_load"
_RELOCATED, _RODATA, _BSS = 0x10, 0x20, 0x40  # scope flags of viper code
_TUPLE, _TEXTS, _CONSTANTS = 10, (5, 6), (0, 1, 2, 3, 4)  # objects: a tuple; str and bytes; those without a length
_HEADER_BYTES = 4
_HEAP_BLOCK = 16  # bytes, of MicroPython's heap
_NONE = b"\1"  # an object without a length


Module = namedtuple("Module", "functions end names texts")  # see functions_of()


class Function:
    """A function in an .mpy: where it begins, its code's offset and length in bytes, its kind, and its table's fields."""

    def __init__(self, begin, offset, length, kind):
        self.begin = begin  # of the number before the code
        self.offset = offset
        self.length = length
        self.kind = kind
        self.children = 0
        self.prelude = 0
        self.generator = 0


class _Reader:
    """Reads an .mpy from a position on: numbers, names, objects, functions."""

    def __init__(self, data):
        self.data = data
        self.at = 0

    def read_number(self):
        """Return the number at the reader's position: seven bits a byte, the highest first."""
        value = 0
        while True:
            byte = self.data[self.at]
            self.at += 1
            value = value << 7 | byte & 0x7F
            if not byte & 0x80:
                return value

    def skip_name(self):
        """Pass over a name."""
        length = self.read_number()
        if not length & 1:  # otherwise one of the interpreter's own
            self.at += (length >> 1) + 1

    def read_object(self):
        """Pass over an object; return (its kind, bytes of text that it has)."""
        kind = self.data[self.at]
        self.at += 1
        if kind in _CONSTANTS:
            return kind, 0
        length = self.read_number()
        if kind == _TUPLE:
            for _ in range(length):
                self.read_object()
        else:
            self.at += length + (kind in _TEXTS)  # they end with a zero
        return kind, length

    def is_generator(self, at):
        """Return 1 if the prelude at `at` is a generator's, else 0: bit 6 of its second byte, if there is one (MP_BC_PRELUDE_SIG_ENCODE)."""
        return self.data[at + 1] >> 6 & 1 if self.data[at] & 0x80 else 0

    def read_function(self, found):
        """Add the function at the reader's position, and those inside it, to `found`. Raises ValueError."""
        begin = self.at
        number = self.read_number()
        function = Function(begin, self.at, number >> 3, (number & 3) + BYTECODE)
        found.append(function)
        self.at += function.length
        self._read_native(function)
        if number & 4:
            function.children = self.read_number()
            for _ in range(function.children):
                self.read_function(found)

    def _read_native(self, function):
        """Read what stands behind a function's code: its prelude, or the flags and constants of viper. Raises ValueError for relocated code."""
        kind = function.kind
        if kind == BYTECODE:
            function.generator = self.is_generator(function.offset)
            return
        flags = self.read_number()  # NATIVE: where its prelude begins
        if kind == NATIVE:
            function.prelude = flags
            function.generator = self.is_generator(function.offset + flags)
        elif kind == VIPER:
            if flags & _RELOCATED:
                raise ValueError("native code that is relocated")
            constants = self.read_number() if flags & _RODATA else 0
            if flags & _BSS:
                self.read_number()
            self.at += constants


def functions_of(data):
    """Return a Module: the functions of an .mpy, outer ones first; its length; where its names end; its texts among its constants: (number, where it
    begins behind the names, length). Raises ValueError if it is not of version 6."""
    if data[:2] != b"M\x06":
        raise ValueError("no .mpy of version 6")
    reader = _Reader(data)
    reader.at = _HEADER_BYTES
    names, objects = reader.read_number(), reader.read_number()
    for _ in range(names):
        reader.skip_name()
    behind_names = reader.at
    texts = []
    for number in range(objects):
        kind, length = reader.read_object()
        if kind in _TEXTS:
            texts.append((number, reader.at - length - 1 - behind_names, length))
    found = []
    reader.read_function(found)
    return Module(found, reader.at, behind_names, texts)


def block_starts(size):
    """Return the offsets in the file at which its blocks begin, and how many bytes of pointers stand before each (littlefs: ctz(n) + 1 pointers)."""
    starts, pointers = [0], [0]
    while starts[-1] < size:
        number = len(starts)
        starts.append(starts[-1] + BLOCK_BYTES - pointers[-1])
        pointers.append(4 * ((number & -number).bit_length()))
    return starts, pointers


def padding_before(function, offset, native):
    """Return how many bytes to move a function that would begin at `offset`, so that it crosses no block and, if `native`, begins at a multiple of
    four."""
    moved = -offset % 4 if function.kind != BYTECODE and native else 0
    starts, pointers = block_starts(offset + moved + function.length + BLOCK_BYTES)
    for begin, end in zip(starts, starts[1:]):
        if begin <= offset + moved < end and offset + moved + function.length > end:
            following = BLOCK_BYTES - pointers[starts.index(end)]
            if function.length <= following:  # blocks begin at multiples of four
                moved = end - offset
    return moved


def in_place(data, native=False):
    """Return the .mpy with its functions moved and a table of them appended. `native`: viper and native code run in place, too. Raises ValueError if
    the table cannot hold a function."""
    found, end, names, texts = functions_of(data)
    code = sum(function.length for function in found[1:])
    if found[0].kind != BYTECODE or len(data) <= INLINE_BYTES and code < _WORTH:
        return _with_object(data[:end], names) + struct.pack(_END, 0, 0, 0, 0, 0, 0, MARK)
    head, count, first = _longer_head(data, names, found[0].begin)
    out, copied, table = bytearray(head), found[0].begin, bytearray()
    small = max(0, INLINE_BYTES + 1 - len(data))
    for function in found:
        stays = function.kind != BYTECODE and not native
        out += data[copied : function.begin]
        before = function.offset - function.begin
        if not stays:
            out += b"\x80" * small  # so that the file has a block of its own
            small = 0
            out += b"\x80" * padding_before(function, len(out) + before, native)
        out += data[function.begin : function.offset]
        copied = function.offset
        if len(out) >= 1 << 16 or function.children > 255:
            raise ValueError("more than 64 kB, or than 255 functions in one")
        block, start = _block_of(len(out), function.length) if not stays else (_MEMORY, len(out))
        table += struct.pack(_ROW, start, function.length, function.prelude, block, function.kind, function.children, function.generator)
    out += data[copied:end]
    behind = len(head) - (found[0].begin - names)
    texts_at = [(number, *_block_of(behind + at, length + 1)) for number, at, length in texts if number < 256 and length]
    texts_at = [struct.pack(_TEXT, start, block, number) for number, block, start in texts_at if block != _MEMORY]
    call = _call_bytes(count - 1)
    count = count if len(head) <= BLOCK_BYTES else 0
    table += b"".join(texts_at)
    return bytes(out + table + call + struct.pack(_END, len(head), count, first, len(call), len(found), len(texts_at), MARK))


def _longer_head(data, names, begin):
    """Return (the bytes before the functions, with the name _CALLED added; how many names there are; where they begin)."""
    reader = _Reader(data)
    reader.at = _HEADER_BYTES
    count = reader.read_number() + 1
    constants = reader.at
    reader.read_number()
    first = data[:_HEADER_BYTES] + _number_bytes(count) + data[constants : reader.at]
    head = first + data[reader.at : names] + _number_bytes(2 * len(_CALLED)) + _CALLED + b"\0"
    return _with_object(head + data[names:begin], len(head)), count, len(first)


def _with_object(data, names):
    """Return `data`, whose names end at offset `names`, with one object added if it has none and its names fill their piece of the heap. MicroPython
    puts the numbers of names, two bytes each in whole words, and behind them the objects into one piece, and keeps a pointer to where objects begin.
    If names fill the piece and there is no object, that points at the next piece, which is never collected then. Cost: 16 bytes."""
    reader = _Reader(data)
    reader.at = _HEADER_BYTES
    count = reader.read_number()
    constants = reader.at
    if reader.read_number() or (count + 1) // 2 * 4 % _HEAP_BLOCK:
        return data
    return data[:constants] + b"\1" + data[constants + 1 : names] + _NONE + data[names:]


def _number_bytes(value):
    """Return a number as .mpy files and bytecode have it: seven bits a byte, the highest first."""
    out = bytes([value & 0x7F])
    while value := value >> 7:
        out = bytes([value & 0x7F | 0x80]) + out
    return out


def _call_bytes(name):
    """Return a function in bytecode that calls the global of name number `name`, and then the result: `name()()`."""
    code = b"\x00\x02\x00" + b"\x11" + _number_bytes(name) + b"\x34\x00\x34\x00\x59\x51\x63"
    return _number_bytes(len(code) << 3) + code


def _block_of(offset, length):
    """Return the block in which code at an offset of the file lies, and where in it; _MEMORY and the offset if it crosses one."""
    starts, pointers = block_starts(offset)
    block = max(number for number, start in enumerate(starts) if start <= offset)
    start = offset - starts[block] + pointers[block]
    return (block, start) if start + length <= BLOCK_BYTES else (_MEMORY, offset)
