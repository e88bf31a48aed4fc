"""Code in flash: functions run from their .mpy files in mapped flash, and the collector frees their copies in RAM.

    code = FlashCode()
    code.begin()            # before the app is imported
    ...                     # imports
    code.finish()           # nothing is redirected from here on
    print(code.text())

An interpreter loads an .mpy into RAM: 75 kB of bytecode for a router. It lies in the file as it is loaded, and
littlefs never moves the blocks of a file that nobody writes. So each function's pointer is turned to the equal bytes of
its own file. Where the blocks are, littlefs itself tells: while the app starts, files are opened here, through a block
device that notes which block is read. `host_tools/build/mpy.py` appends a table of functions to each .mpy and sees to it that
they do not cross a block.

Safe by these rules: every byte is compared first; nothing is redirected into which anything points (running functions,
suspended generators); a trial at the start finds out whether the interpreter keeps functions as is expected, and if not,
or if anything fails, all stays in RAM. Blocks that hold code in use are not erased until the next reset, even if their
file is replaced: littlefs takes them for bad ones and goes on to the next.

Files of 512 bytes and less have no block of their own: their code stays in RAM. So does native code, half as fast from flash,
but for COLD of host_tools/build/tree.py. A module without a table was not copied to its end, and is refused. RP2040 only.
"""

import gc
import sys
from array import array

import micropython
import rp2
import uctypes
import vfs
from machine import mem32
from micropython import const

from passo.ports.rp2.fields import FILE_ROW, FUNCTION_ROW, WORK_ROW
from passo.ports.rp2.flash_files import BLOCK, Blocks, Files, Unknown, mount
from passo.ports.rp2.flash_scan import (
    BLOCKS, BUSY, FIELDS, FILE_COUNT, FILES, FREE, FUNCTION_CHILDREN, FUNCTION_CODE, FUNCTION_MODULE, IN_USE, KIND_SHIFT,
    MOVED, MOVED_BYTES, POOL, RAW_CODE, STACK, TYPES, WORK, WORK_ROWS,
)  # fmt: skip

_SCAN = "passo.ports.rp2.flash_scan"  # loaded, then given back
_IOCTL_COUNT = const(4)
_SMALL = const(512)  # littlefs keeps files up to this size beside their names
_PAGE = const(256)  # as the interpreter mounts it
_FLASH = const(0x10000000)
_FLASH_END = const(0x11000000)
_FIRST_ROUND = const(80_000)  # bytes of files after which their functions are redirected: there is room at first
_ROUND = const(24_000)  # each takes 20 to 40 ms
_LITTLE = const(10_000)  # the same while less than _TIGHT bytes are free; half of it where no room is kept
_TIGHT = const(50_000)
_STEP = const(1_500)  # bytes of files between two looks at what is free: each takes 1 ms
_PIECE = const(200)  # bytes: if no free piece is longer by this than a module's longest function, the room is given back
_FEW = const(12_000)  # the same if no more are free in all, nor twice the file: the largest modules take as much
_LEFT = const(300)  # bytes of a module that are tried again at last: of less some are garbage, and the record takes as much
_WORK_ROWS = const(96)
_FILES = const(96)  # redirected at once


@micropython.native
def _times(number):  # this and the next two are for the trial
    return number * 7


@micropython.native
def _plus(number):
    return number + 7


@micropython.native
def _minus(number):
    return number - 7


class Record:
    """Where the functions of a module lie."""

    def __init__(self, path, functions):
        self.path = path
        self.functions = functions


def _name(path):
    """The name of the module whose .mpy lies there."""
    name = path[:-4].replace("/", ".")
    return name[:-9] if name.endswith(".__init__") else name


class FlashCode:
    def __init__(self, rooms=([], [])):
        """`rooms`: what keeps memory free; if memory is short its first two, lists, are emptied one after the other."""
        self.why = "not tried"  # all stays in RAM; "" if not
        self._rooms = rooms
        self.functions = self.bytes = 0
        self._real = self._blocks = self._words = None
        self._records = []
        self._left = []
        self._read = 0  # bytes of files since the last round
        self._limit = _FIRST_ROUND
        self._look_at_read = _STEP

    def begin(self):
        """Try whether code can be redirected here; if so, take the file system over."""
        try:
            self._prepare()
            self._trial()
            for name, module in list(sys.modules.items()):
                if name.startswith("passo") and name != _SCAN:
                    self._look_at(module.__file__)
        except Exception as error:
            self._give_up(error)
            self._real = None
            return
        mount(Files(self._real, self))

    def finish(self):
        """The last round. Then the file system is littlefs again, on a flash whose blocks with code are kept."""
        if self._real is None:
            return
        self._round(True)
        mount(self._real)
        self._real = None
        self._drop()

    def text(self):
        if self.why:
            return "code in RAM: " + self.why
        return "code in flash: %d functions, %d bytes" % (self.functions, self.bytes)

    def redirect(self, poor=False):
        """Give back the copies of what has been loaded so far. `poor`: and 100 bytes a module, for which some of it stays in RAM."""
        if poor:
            self._left = []
        self._round()

    def open(self, path):
        """An .mpy for the import: its functions are noted, those of earlier ones perhaps redirected."""
        file = self._real.open(path, "rb")
        table = self._blocks.table(file)
        if table and self._is_short(file, table[0], table[1]):
            gc.collect()
            if self._is_short(file, table[0], table[1]):
                self._round()
                if self._is_short(file, table[0], table[1]):
                    self._give_back()
        if self._read > self._limit or self._read > self._look_at_read and self._is_tight():
            self._round()
        if table is None:  # the interpreter would read on for ever
            raise ValueError(path + " is not whole: flash it anew")
        if self._words:
            try:
                self._note(path, file, *table)
            except MemoryError:
                raise  # it may be imported again when there is more memory
            except Exception as error:
                self._give_up(error)
        file.seek(0)
        return file

    # --- inside

    def _give_up(self, error):
        """No more is redirected. What has been stays where it is: it is right."""
        self.why = str(error) or type(error).__name__
        self._drop()

    def _drop(self):
        """Give back what only the start needs."""
        if _SCAN in sys.modules:
            package, _, name = _SCAN.rpartition(".")
            scan = sys.modules.pop(_SCAN)
            delattr(sys.modules[package], name)
            scan.__dict__.clear()  # its functions go even if something that looks like a pointer keeps the module
        self._words = self._in_use = self._work = self._files = None
        self._records = self._left = ()

    def _prepare(self):
        if "RP2040" not in sys.implementation._machine:
            raise Unknown("no RP2040")
        flash = rp2.Flash()
        mapped = memoryview(flash)
        base = uctypes.addressof(flash)
        count = flash.ioctl(_IOCTL_COUNT, 0)
        if len(mapped) != count * BLOCK or not _FLASH <= base < base + len(mapped) <= _FLASH_END:
            raise Unknown("the file system is not mapped")
        from passo.ports.rp2.flash_scan import counted, find_heap, mark, trial

        self._blocks = Blocks(flash, count, base)
        self._words = words = array("I", [0] * FIELDS)
        if find_heap(words) != 1:
            raise Unknown("unknown heap")
        self._in_use = bytearray((words[BLOCKS] + 31) // 32 * 4)
        self._work = array("I", [0] * (_WORK_ROWS * WORK_ROW))
        words[IN_USE] = uctypes.addressof(self._in_use)
        words[WORK] = uctypes.addressof(self._work)
        words[WORK_ROWS] = _WORK_ROWS
        self._files = array("I", [0] * (_FILES * FILE_ROW))  # here, for a round may find no piece as large
        words[FILES] = uctypes.addressof(self._files)
        for number, function in enumerate((trial, counted, mark, _times)):
            words[TYPES + number] = id(type(function))
        self._real = vfs.VfsLfs2(self._blocks, progsize=_PAGE)

    def _look_at(self, path):
        """The record of a module that is loaded already, or None."""
        known = len(self._records)
        with self._real.open(path, "rb") as file:
            table = self._blocks.table(file)
            if table:
                self._note(path, file, *table)
        return self._records[-1] if len(self._records) > known else None

    def _note(self, path, file, size, count, head):
        """Note where the functions of an .mpy lie. `head`: the last block, which begins littlefs's list of them."""
        from passo.ports.rp2.flash_scan import locate

        self._read += size
        if size <= _SMALL or head < 0:
            return
        table = self._rows(file, size, count)
        functions = array("I", [0] * (count * FUNCTION_ROW))
        locate(table, count, self._blocks.chain(size, head), functions)
        self._records.append(Record(path, functions))

    def _rows(self, file, size, count):
        """The table that ends an .mpy: where each function lies, its length and others, in 8 bytes."""
        file.seek(size - 4 - 8 * count)
        return file.read(8 * count)

    def _give_back(self):
        """Empty the first list that keeps memory free. Returns its length, 0: there is none."""
        room = self._rooms[0] or self._rooms[1]
        length = len(room)
        room.clear()
        return length

    def _round(self, last=False):
        """Redirect what has been imported since the last one; in the last, also what was running then."""
        self._read = 0
        self._limit = _ROUND
        self._look_at_read = _STEP
        if not self._words:
            return
        from passo.ports.rp2.flash_scan import left

        try:
            records = self._records + self._left if last else self._records
            self._redirect(records)
            if not last:
                self._left.extend([record for record in records if left(record.functions, len(record.functions)) > _LEFT])
            self._records = []
        except MemoryError as error:
            if self._give_back():
                self._round(last)
            elif last:  # until then the next one tries again
                self._give_up(error)
        except Exception as error:
            self._give_up(error)
            return
        gc.collect()

    def _is_tight(self):
        self._look_at_read = self._read + _STEP
        if not self._words:
            return False
        self._largest()
        return self._words[FREE] < _TIGHT and self._read > (_LITTLE if self._rooms[0] else _LITTLE // 2)

    def _is_short(self, file, size, count):
        """Whether memory is short for a module of `count` functions."""
        if not self._words:
            return False
        largest = self._largest()
        if self._words[FREE] < min(2 * size, _FEW):
            return True
        if largest >= size:
            return False
        rows = self._rows(file, size, count)
        return largest < _PIECE + max([rows[at] | rows[at + 1] << 8 for at in range(2, 8 * count, 8)])

    def _largest(self):
        if not self._words:
            return _PIECE
        from passo.ports.rp2.flash_scan import largest

        return largest(self._words)

    def _redirect(self, records):
        from passo.ports.rp2.flash_scan import mark, redirect, stack_pointer

        words, rows = self._words, self._files
        for first in range(0, len(records), _FILES):
            at = 0
            for number in range(first, min(first + _FILES, len(records))):
                record = records[number]
                module = sys.modules.get(_name(record.path))
                if module and module.__file__ == record.path:  # some are forgotten again
                    rows[at] = id(module)
                    rows[at + 1] = uctypes.addressof(record.functions)
                    rows[at + 2] = len(record.functions) // FUNCTION_ROW
                    at += FILE_ROW
            words[FILE_COUNT] = at // FILE_ROW
            words[STACK] = stack_pointer()
            mark(words)
            redirect(words)
        self.functions = words[MOVED]
        self.bytes = words[MOVED_BYTES]

    # --- the trial

    def _trial(self):
        """Raises Unknown unless functions are kept as flash_scan.py says, shown by three that are known."""
        from passo.ports.rp2.flash_scan import counted, trial

        module = sys.modules[_SCAN]
        functions, children = FUNCTION_CODE, FUNCTION_CHILDREN
        record = self._look_at(module.__file__)
        if record is None:
            raise Unknown("flash_scan.mpy has no table")
        suspended = counted()
        next(suspended)
        found = [number for number in range(4) if self._function_of(record, mem32[id(trial) + 4 * number])]
        entry = self._function_of(record, mem32[id(trial) + 4 * functions])
        child = mem32[mem32[id(trial) + 4 * children]] if entry else 0
        code_of_counted = mem32[id(counted) + 4 * functions]
        counted_entry = self._function_of(record, code_of_counted)
        if (
            found != [functions]
            or not counted_entry
            or mem32[id(trial)] != id(type(trial))
            or mem32[id(trial) + 4 * FUNCTION_MODULE] != id(module)
            or not self._in_heap(child)
            or mem32[child] != 2 << KIND_SHIFT
            or self._function_of(record, mem32[child + 4 * RAW_CODE]) != entry + 1
        ):
            raise Unknown("unknown layout of functions")
        code, code_of_child = mem32[id(trial) + 4 * functions], mem32[child + 4 * RAW_CODE]
        self._redirect([record])
        target = record.functions[(entry - 1) * FUNCTION_ROW]
        target_of_child = record.functions[entry * FUNCTION_ROW]
        moved = mem32[id(trial) + 4 * functions] == target
        child_moved = mem32[child + 4 * RAW_CODE] == target_of_child
        if (
            not (moved or child_moved)  # one of them may be left alone: instructions may look like a pointer into it
            or moved == self._used(code, record, entry)
            or child_moved == self._used(code_of_child, record, entry + 1)
            or mem32[id(counted) + 4 * functions] != code_of_counted
            or not self._used(code_of_counted, record, counted_entry)
        ):
            raise Unknown("the trial ended otherwise")
        if trial(6) != 43 or trial(0)(2) != 15 or list(suspended) != [4]:
            raise Unknown("code does not run from flash")
        self._trial_of_native()
        self._records.clear()
        self._words[MOVED] = self._words[MOVED_BYTES] = self._words[BUSY] = 0
        self.why = ""

    def _trial_of_native(self):
        """The same of functions in native code, which have another pointer into themselves, to their prelude. One of them may
        be left alone, because a stale word on the stack points into it."""
        module = sys.modules[__name__]
        record = self._look_at(module.__file__)
        before = []
        for function in (_times, _plus, _minus):
            code = mem32[id(function) + 4 * FUNCTION_CODE]
            prelude = mem32[id(function) + 4 * FUNCTION_CHILDREN] - code
            entry = self._function_of(record, code) if record else 0
            if not entry or not 0 < prelude < record.functions[entry * FUNCTION_ROW - 2] & 0xFFFF:
                raise Unknown("unknown layout of native code")
            before.append((function, code, prelude, record.functions[(entry - 1) * FUNCTION_ROW]))
        self._redirect([record])
        moved = 0
        for function, code, prelude, target in before:
            now = mem32[id(function) + 4 * FUNCTION_CODE]
            moved += now == target
            if now not in (code, target) or mem32[id(function) + 4 * FUNCTION_CHILDREN] != now + prelude:
                raise Unknown("the trial of native code ended otherwise")
        if not moved or (_times(6), _plus(6), _minus(6)) != (42, 13, -1):
            raise Unknown("native code does not run from flash")

    def _in_heap(self, address):
        words = self._words
        return address & 3 == 0 and 0 <= address - words[POOL] < 16 * words[BLOCKS]

    def _function_of(self, record, address):
        """The number, from 1, of the function in flash whose bytes stand at an address in RAM; 0: none."""
        if not self._in_heap(address):
            return 0
        row = FUNCTION_ROW
        for number in range(len(record.functions) // row):
            target, length = record.functions[number * row], record.functions[number * row + 1] & 0xFFFF
            if target and uctypes.bytearray_at(address, length) == uctypes.bytearray_at(target, length):
                return number + 1
        return 0

    def _used(self, address, record, number):
        """Whether something points into the copy of a function."""
        first = address - self._words[POOL]
        length = record.functions[(number - 1) * FUNCTION_ROW + 1] & 0xFFFF
        blocks = range(first >> 4, first + length + 15 >> 4)
        return bool([block for block in blocks if self._in_use[block >> 3] >> (block & 7) & 1])
