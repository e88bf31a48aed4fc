"""Code in flash: while the app is imported, functions are made that run where their .mpy files lie in the mapped flash.

    code = FlashCode()
    code.begin()            # before the app is imported
    ...                     # imports
    code.finish()           # what is imported from here on is loaded into memory
    print(code.text())

docs/inside/build.md has the reasons, and the conditions that make it safe. The interpreter is given the head of each file, which has its
names and constants, and instead of its functions one that calls `_load()()`: that makes the module's functions here, as the interpreter
would, but bytecode stays where it is. `host_tools/build/mpy.py` appends what is to be known of a file's functions, and sees to it that they
do not cross a block. Blocks that hold code are not erased until the next reset: littlefs takes them for bad ones and goes on to the next.
RP2040 only. Of MicroPython 1.26 to 1.29 is known:

    mp_obj_fun_bc_t      type, module, children, code                   (py/objfun.h)
    mp_raw_code_t        0, 0, kind, generator; code, children          (py/emitglue.h); bytecode without children can do without one

Files of 512 bytes and less have no block of their own, and modules of kernels are all machine code: the interpreter loads them. A
file whose end is missing was not copied to its end, and is refused.
"""

import builtins
import sys
from array import array
from io import BytesIO
from struct import unpack_from
from uctypes import addressof, bytearray_at

import rp2
import vfs
from machine import mem16, mem32
from micropython import const

from passo.ports.rp2 import clock
from passo.ports.rp2.fields import FLASH_BLOCK, FLASH_PAGE, IOCTL_COUNT
from passo.ports.rp2.stock.flash_files import ROW_BYTES, TEXT_BYTES, Blocks, Files, Unknown, mount
from passo.ports.rp2.stock.flash_names import KNOWN_BYTES, learn, limit_next_table, look, move, shorten, take

code = None  # see begin()
_COLLECT = const(72_000)  # bytes taken on a board with a radio until garbage is collected: see begin()
_BUFFER_BYTES = const(4608)  # more than any file has before its functions
_TEXTS_BYTES = const(4096)  # of names that do not lie in flash: more than most boards have
_LAYOUT = "unknown layout of functions"
_FLASH = const(0x10000000)
_FLASH_END = const(0x11000000)
_RAM = const(0x20000000)
_RAM_END = const(0x20042000)
_STATIC = const(4000)  # words of memory: the interpreter's own begin it
_ROW = "<HHHBBBB"
_MEMORY = const(255)  # for a block's number: it is copied into memory
_TEXT = "<HBB"
_NUMBERS = const(8)  # in a module: of its names
_CONSTANTS = const(12)
_LENGTH = const(8)  # in a text
_DATA = const(12)
_ZEROS = bytes(64)
_MOST_NAMES = const(12)  # new ones of a file that the interpreter loads
_MODULE = const(4)  # in a function
_CHILDREN = const(8)
_CODE = const(12)
_KIND_SHIFT = const(16)  # in the first word of a raw code
_GENERATOR_SHIFT = const(24)
_BYTECODE = const(2)
_NATIVE = const(3)


def _new_function():
    """Return a new function, to be given other code."""

    def function():
        return 7

    return function


def _is_ram(address):
    """Return True if an address is in memory."""
    return _RAM <= address < _RAM_END


def _equal(address, target, length):
    """Return True if the same bytes are in memory and in flash."""
    return _is_ram(address) and 0 < length <= FLASH_BLOCK and bytearray_at(address, length) == bytearray_at(target, length)


def _word(address):
    """Return the word at an address in memory. Raises Unknown if there can be none."""
    if not _is_ram(address) or address & 3:
        raise Unknown(_LAYOUT)
    return mem32[address]


def begin():
    """Begin main.py, at the chip's full speed."""
    global code
    clock.hurry()
    if hasattr(rp2, "country"):  # a radio, whose driver takes 40 kB: collect early, or objects that stay lie all over the rest. Cost: 15 ms
        import gc

        gc.threshold(_COLLECT)
    code = FlashCode()
    code.begin()


class FlashCode:
    def __init__(self):
        self.why = "not tried"  # all is loaded into memory; "" if not
        self.functions = self.bytes = 0
        self._real = self._blocks = None
        self._path = ""  # of the module that is being imported, and its file, the addresses of its blocks, what is known of its functions
        self._file = self._addresses = self._rows = None
        self._functions = 0  # the end of the table of its functions
        self._names = 0  # how many names it has, and where they begin; 0: in more than a block
        self._known = None  # see flash_names.py
        self._texts = None  # a piece of memory for texts of names
        self._text = None  # the .mpy as the interpreter reads it
        self._at = 0  # the next one
        self._address = self._inside = 0  # of the one made last: its code, its children or what else the interpreter has there

    def begin(self):
        """Try whether functions are as expected; if so, take the file system over."""
        try:
            self._prepare()
            self._try(sys.modules[__name__].__file__)
        except Exception as error:
            self.why = str(error) or type(error).__name__
            self._real = None
            return
        self.why = ""
        self.functions = self.bytes = 0
        setattr(builtins, "_load", self._load)
        mount(Files(self._real, self))
        self._texts = bytearray(_TEXTS_BYTES)
        take(self._known, addressof(self._texts), _TEXTS_BYTES)

    def borrow(self, piece):
        """Use `piece`, an array of zeros, as the buffer of heads until finish(), which fills it with zeros again. It stays anyway; a buffer
        of its own may never be freed, because the collector takes old words on the stack for pointers to it."""
        if self._real is not None:
            self._text = memoryview(bytearray_at(addressof(piece), _BUFFER_BYTES))

    def finish(self):
        """The file system is littlefs again, on a flash whose blocks with code are kept."""
        if self._real is None:
            return
        mount(self._real)
        for at in range(0, _BUFFER_BYTES, len(_ZEROS)):
            self._text[at : at + len(_ZEROS)] = _ZEROS
        there = addressof(self._texts)
        try:
            texts = bytearray(move(self._known, there, 0) or 1)  # the first of the names keeps it
            move(self._known, there, addressof(texts))
        except MemoryError:
            pass  # they stay where they are, with room for more
        self._real = self._file = self._known = self._text = self._texts = None
        delattr(builtins, "_load")

    def text(self):
        if self.why:
            return "code in RAM: " + self.why
        return "code in flash: %d functions, %d bytes" % (self.functions, self.bytes)

    def open(self, path):
        """Open an .mpy for the import: the bytes before its functions, and the call of _load()."""
        file = self._real.open(path, "rb")
        table = self._blocks.table(file)
        if table is None:  # the interpreter would read on for ever
            raise ValueError(path + " is not whole: flash it anew")
        size, head, names, functions, rows, call, last = table
        file.seek(0)
        if not head:
            limit_next_table(self._known, _MOST_NAMES)
            return file
        self._addresses = self._blocks.chain(size, last)
        self._path, self._file, self._rows = path, file, rows  # three at a time: more are a tuple, garbage that the next module may keep
        self._names, self._functions, self._at = names, functions, 0
        size = head + len(call)
        text = self._text[:size]
        file.readinto(text)
        text[head:] = call
        if self._names:
            size = shorten(text, size << 16 | self._names >> 16, self._names & 0xFFFF, self._known)
        return BytesIO(text[:size])

    # --- inside

    def _prepare(self):
        """Find the mapped file system, and make blocks, buffers and the file system's reader. Raises Unknown on other chips or layouts."""
        if "RP2040" not in sys.implementation._machine:
            raise Unknown("no RP2040")
        flash = rp2.Flash()
        mapped = memoryview(flash)
        base = addressof(flash)
        count = flash.ioctl(IOCTL_COUNT, 0)
        if len(mapped) != count * FLASH_BLOCK or not _FLASH <= base < base + len(mapped) <= _FLASH_END:
            raise Unknown("the file system is not mapped")
        self._blocks = Blocks(flash, count, base)
        self._known = array("I", bytearray(KNOWN_BYTES))
        look(_RAM, _STATIC, self._known)
        self._text = memoryview(bytearray(_BUFFER_BYTES))
        self._real = vfs.VfsLfs2(self._blocks, progsize=FLASH_PAGE)

    def _load(self):
        """Make the functions of the module that is being imported. Returns the outermost one. The code in a file's head instead of its
        functions calls both: if _load() called the function, each import within another would take more of the stack.
        """
        name = self._path[:-4].replace("/", ".")
        module = sys.modules[name[:-9] if name.endswith(".__init__") else name]
        function = _new_function()
        if self._names:
            learn(self._addresses[0], self._names, mem32[id(module) + _NUMBERS], self._known)
        self._point(function, module)
        self._point_texts(mem32[id(module) + _CONSTANTS])
        self._file = self._rows = None
        return function

    def _point(self, function, module):
        """Give a function the file's first code, and all that is in it."""
        self._code()  # until its children are noted there is no other allocation, which might collect them
        mem32[id(function) + _CHILDREN] = self._inside
        mem32[id(function) + _CODE] = self._address
        mem32[id(function) + _MODULE] = id(module)

    def _point_texts(self, constants):
        """Let texts among a module's constants lie in its file; those that are names already stay. Returns how many do."""
        count = 0
        for at in range(self._functions, len(self._rows), TEXT_BYTES):
            offset, block, number = unpack_from(_TEXT, self._rows, at)
            text = mem32[constants + 4 * number]
            target = self._addresses[block] + offset
            if not text & 3 and _equal(mem32[text + _DATA], target, mem32[text + _LENGTH]):
                mem32[text + _DATA] = target
                count += 1
        return count

    def _code(self):
        """Return the address of the next function's code as the interpreter wants it: of a raw code, or of bytecode itself."""
        offset, length, prelude, block, kind, children, generator = unpack_from(_ROW, self._rows, self._at)
        self._at += ROW_BYTES
        if block == _MEMORY:
            copy = bytearray(length)
            self._file.seek(offset)
            self._file.readinto(copy)
            address = addressof(copy)
        else:
            address = self._addresses[block] + offset
            self.functions += 1
            self.bytes += length
            if kind == _BYTECODE and not children:
                self._address, self._inside = address, 0
                return address
        table = None
        inside = address + prelude if kind == _NATIVE else 0
        if children:
            table = array("I", bytearray(4 * (children + 1)))
            for number in range(children):
                table[number] = self._code()
            table[children] = inside
            inside = addressof(table)
        raw = array("I", (generator << _GENERATOR_SHIFT | kind << _KIND_SHIFT, address, inside, 0))
        self._address, self._inside = address, inside
        return addressof(raw)

    def _try(self, path):
        """Raises Unknown unless _new_function() is as it is expected, and a function made of its file runs."""
        module = sys.modules[__name__]
        self.open(path)
        if self._file is None:
            raise Unknown("flash_code.mpy has no table")
        made = _new_function()
        self._at = outer = self._find(_word(id(_new_function) + _CODE))
        raw = _word(_word(id(_new_function) + _CHILDREN))
        if (
            not outer
            or _word(id(_new_function)) != id(type(_new_function))
            or _word(id(_new_function) + _MODULE) != id(module)
            or _word(raw) != _BYTECODE << _KIND_SHIFT
            or _word(raw + 4) != _word(id(made) + _CODE)
            or _word(id(made) + _MODULE) != id(module)
            or self._find(_word(raw + 4)) != outer + ROW_BYTES
        ):
            raise Unknown(_LAYOUT)
        numbers = _word(id(module) + _NUMBERS)
        if not _is_ram(numbers) or mem16[numbers] != id(module.__file__) >> 3:
            raise Unknown("unknown layout of names")
        text = _LAYOUT.encode()
        if (
            _word(id(_LAYOUT) + _LENGTH) != len(text)
            or bytes(bytearray_at(_word(id(_LAYOUT) + _DATA), len(text))) != text
            or not self._point_texts(_word(id(module) + _CONSTANTS))
        ):
            raise Unknown("unknown layout of texts")
        self._point(made, module)
        if made()() != 7:
            raise Unknown("code does not run from flash")
        self._file = self._rows = None

    def _find(self, address):
        """Return the row of the function whose code stands at an address; 0: there is none."""
        for at in range(ROW_BYTES, self._functions, ROW_BYTES):
            offset, length, _, block, *_ = unpack_from(_ROW, self._rows, at)
            if block != _MEMORY and _equal(address, self._addresses[block] + offset, length):
                return at
        return 0
