"""Kernels of flash_code.py: they look through all memory, and are given back when the start is over.

    find_heap(words)        # [pool, blocks, table] of the collector
    mark(words)             # notes what is in use
    redirect(words)         # points functions at their code in flash

`words` is one array('I'): viper takes four arguments at most. Written for the RP2040's 264 kB and MicroPython 1.26 to 1.29;
flash_code.py tries whether the interpreter is like these:

    mp_state_mem_area_t  table, its bytes, finalisers, [weak references], pool, end of the pool     (py/mpstate.h)
    mp_obj_fun_bc_t      type, module, children, code                                               (py/objfun.h)
    mp_raw_code_t        0, 0, kind, generator; code, children                                      (py/emitglue.h)

The collector keeps memory in blocks of 16 bytes, with two bits for each in its table: free, head, tail.
"""
# ruff: noqa: F821

import micropython
from micropython import const

from passo.ports.rp2.fields import (
    AREA_BYTES, AREA_END, AREA_FINALISERS, AREA_POOL, ENTRY_BYTES, ENTRY_FLASH, ENTRY_KIND, FILE_COUNT_OF, FILE_FUNCTIONS,
    FILE_ROW, FUNCTION_ROW, WORK_CHILDREN, WORK_FUNCTIONS, WORK_LAST, WORK_NUMBER, WORK_ROW, WORK_SLOT,
)  # fmt: skip

RAM = const(0x20000000)
RAM_END = const(0x20042000)
_RAM_WORDS = const(0x10800)
_HEAD = const(1)
_TAIL = const(2)

# Fields of `words`
POOL = const(0)  # address of the heap's first block
BLOCKS = const(1)
TABLE = const(2)  # address of the collector's table
IN_USE = const(3)  # address of a bit for each block: something points into it
STACK = const(4)  # the stack's lowest address in use
TYPES = const(5)  # of functions in bytecode, generator functions, those in viper, in native code
FILES = const(9)  # address of rows: module, functions, number of functions
FILE_COUNT = const(10)
WORK = const(11)  # address of rows: address of the pointer, functions, first, behind the last, children
WORK_ROWS = const(12)
MOVED = const(13)  # functions redirected
MOVED_BYTES = const(14)
BUSY = const(15)  # left because something points into them
FREE = const(16)  # bytes
FIELDS = const(17)

# Fields of the interpreter's structures, in words
FUNCTION_MODULE = const(1)
FUNCTION_CHILDREN = const(2)
FUNCTION_CODE = const(3)
RAW_CODE = const(1)
RAW_CHILDREN = const(2)
KIND_SHIFT = const(16)
GENERATOR = const(0x1000000)
# Kinds of functions. Machine code (viper is 4) never runs while this does: only its function points into it, native twice.
_BYTECODE = const(2)
_NATIVE = const(3)


@micropython.asm_thumb
def stack_pointer():
    mov(r0, sp)


@micropython.viper
def find_heap(words: ptr32) -> int:
    """How many descriptions of a heap there are; one is wanted. Writes POOL, BLOCKS and TABLE."""
    ram = ptr32(RAM)
    found = 0
    i = 0
    end = _RAM_WORDS - 6
    while i < end:
        table = ram[i]
        if table > RAM and table < RAM_END:
            length = ram[i + AREA_BYTES]
            if length > 0 and length < 0x1080 and ram[i + AREA_FINALISERS] == table + length + 1:
                at = i + AREA_POOL
                if ram[at + AREA_END] - ram[at] != length << 6:
                    at += 1
                pool = ram[at]
                if ram[at + AREA_END] - pool == length << 6 and pool & 15 == 0 and pool > ram[i + AREA_FINALISERS] and ram[at + AREA_END] <= RAM_END:
                    words[POOL] = pool
                    words[BLOCKS] = length << 2
                    words[TABLE] = table
                    found += 1
                    end = table - RAM >> 2  # what follows is the heap
        i += 1
    return found


@micropython.asm_thumb
def look(r0, r1, r2):
    """Mark what the words from address r0 to r1 point into; r2: `words`. 64 bytes at a time, which is what a byte of the
    collector's table describes; in the heap, if none of them is in use, they are passed over. 9 cycles a word, 40 for a
    pointer into the heap."""
    ldr(r3, [r2, 0])  # POOL
    ldr(r4, [r2, 4])  # BLOCKS
    lsl(r4, r4, 4)  # bytes of the heap
    label(NEXT)
    cmp(r0, r1)
    bcs(END)
    sub(r5, r0, r3)
    cmp(r5, r4)
    bcs(LOOK)  # not in the heap
    lsr(r5, r5, 6)
    ldr(r7, [r2, 8])  # TABLE
    add(r7, r7, r5)
    ldrb(r5, [r7, 0])
    cmp(r5, 0)
    bne(LOOK)
    add(r0, 64)
    b(NEXT)
    label(LOOK)
    mov(r6, 16)
    label(WORD)
    ldr(r5, [r0, 0])
    sub(r5, r5, r3)  # offset in the heap
    cmp(r5, r4)
    bcc(FOUND)
    label(ON)
    add(r0, 4)
    sub(r6, 1)
    bne(WORD)
    b(NEXT)
    label(FOUND)
    push({r0, r1})
    mov(r0, 15)
    and_(r0, r5)
    bne(MARK)  # not at the beginning of a block
    ldr(r7, [r2, 8])
    lsr(r1, r5, 6)
    add(r7, r7, r1)
    ldrb(r7, [r7, 0])  # of four blocks
    lsr(r1, r5, 4)
    mov(r0, 3)
    and_(r1, r0)
    lsl(r1, r1, 1)
    lsr(r7, r1)
    and_(r7, r0)
    cmp(r7, 2)
    bne(DONE)  # not a tail
    label(MARK)
    ldr(r7, [r2, 12])  # IN_USE
    lsr(r1, r5, 7)
    add(r7, r7, r1)
    lsr(r1, r5, 4)
    mov(r0, 7)
    and_(r1, r0)
    mov(r0, 1)
    lsl(r0, r1)
    ldrb(r1, [r7, 0])
    orr(r1, r0)
    strb(r1, [r7, 0])
    label(DONE)
    pop({r0, r1})
    b(ON)
    label(END)


@micropython.viper
def mark(words: ptr32):
    """Set a bit for each block into which, and not at whose object's beginning, anything in use points: a running
    function, a suspended generator, a handler of exceptions. They point into code; only those that point at its
    beginning can be redirected. All memory is looked at but the collector's tables, free blocks and the dead part of
    the stack, the collector's own way, if more strictly: 5 to 8 ms."""
    in_use = ptr32(words[IN_USE])
    count = words[BLOCKS] + 31 >> 5
    i = 0
    while i < count:
        in_use[i] = 0
        i += 1
    pool = words[POOL]
    end = pool + (words[BLOCKS] << 4)
    stack = words[STACK]
    here = int(words)
    look(RAM, words[TABLE], here)
    look(pool, end, here)
    look(RAM_END - (RAM_END - (stack if stack > end else end) + 63 & -64), RAM_END, here)


@micropython.viper
def redirect(words: ptr32):
    """Point function objects, and the raw codes that functions are made of, at the equal code in flash: those of the
    modules in FILES whose copy is nowhere in use. Every byte is compared. About 60 µs a function."""
    pool = words[POOL]
    blocks = words[BLOCKS]
    size = blocks << 4
    table = ptr8(words[TABLE])
    in_use = ptr8(words[IN_USE])
    files = ptr32(words[FILES])
    count = words[FILE_COUNT]
    work = ptr32(words[WORK])
    most = words[WORK_ROWS]
    block = 0
    kinds = 0  # of this block and those after it, up to four in all
    while block < blocks:
        if block & 3:
            kinds >>= 2
        else:
            kinds = table[block >> 2]
            if kinds & 0x55 == 0:  # no head among these four
                block += 4
                continue
        here = pool + (block << 4)
        block += 1
        if kinds & 3 != _HEAD:
            continue
        row = ptr32(here)
        kind = row[0]
        i = 0
        while i < 4 and kind != words[TYPES + i]:
            i += 1
        if i == 4:
            continue
        file = 0
        while file < count * FILE_ROW and files[file] != row[FUNCTION_MODULE]:
            file += FILE_ROW
        if file == count * FILE_ROW:
            continue
        work[WORK_SLOT] = here + FUNCTION_CODE * 4
        work[WORK_FUNCTIONS] = files[file + FILE_FUNCTIONS]
        work[WORK_NUMBER] = 0
        work[WORK_LAST] = files[file + FILE_COUNT_OF]
        work[WORK_CHILDREN] = row[FUNCTION_CHILDREN]
        depth = 1
        while depth:
            depth -= 1
            at = depth * WORK_ROW
            slot = ptr32(work[at + WORK_SLOT])
            functions = ptr32(work[at + WORK_FUNCTIONS])
            number = work[at + WORK_NUMBER]
            last = work[at + WORK_LAST]
            children = work[at + WORK_CHILDREN]
            code = slot[0]
            inside = code - pool
            room = 0  # blocks of the copy in RAM
            first = inside >> 4
            if inside >= 0 and inside < size and inside & 15 == 0:
                if table[first >> 2] >> ((first & 3) << 1) & 3 == _HEAD:
                    room = 1
                    while first + room < blocks:
                        if table[first + room >> 2] >> ((first + room & 3) << 1) & 3 != _TAIL:
                            break
                        room += 1
            found = -1
            while number < last:
                entry = number * FUNCTION_ROW
                target = functions[entry]
                length = functions[entry + ENTRY_BYTES] & 0xFFFF
                if target:
                    if code == target:
                        found = number
                        break
                    if room and room == length + 15 >> 4:
                        copy = ptr8(code)
                        flash = ptr8(target)
                        i = 0
                        while i < length:
                            if copy[i] != flash[i]:
                                break
                            i += 1
                        if i == length:
                            found = number
                            break
                number += 1
            if found < 0:
                continue
            entry = found * FUNCTION_ROW
            if code != functions[entry]:
                busy = 0
                prelude = -1
                if functions[entry + ENTRY_KIND] & 0xFF == _BYTECODE:
                    i = first
                    while i < first + room:
                        busy |= in_use[i >> 3] >> (i & 7) & 1
                        i += 1
                elif functions[entry + ENTRY_KIND] & 0xFF == _NATIVE:
                    prelude = children - code
                    if prelude < 0 or prelude >= functions[entry + ENTRY_BYTES] & 0xFFFF:
                        busy = 1
                if busy:
                    words[BUSY] = words[BUSY] + 1
                else:
                    if prelude >= 0:
                        ptr32(int(slot) - 4)[0] = functions[entry] + prelude
                    slot[0] = functions[entry]
                    if functions[entry + ENTRY_BYTES] < 0x10000:  # counted once
                        functions[entry + ENTRY_BYTES] = functions[entry + ENTRY_BYTES] | 0x10000
                        words[MOVED] = words[MOVED] + 1
                        words[MOVED_BYTES] = words[MOVED_BYTES] + (room << 4)
            if children & 3 or children < pool or children >= pool + size:
                continue
            left = functions[entry + ENTRY_KIND] >> 8 & 0xFF
            child = found + 1
            raws = ptr32(children)
            while left:
                left -= 1
                raw = raws[0]
                raws = ptr32(int(raws) + 4)
                tree = functions[child * FUNCTION_ROW + ENTRY_KIND] >> 16 & 0xFFFF
                if raw & 15 == 0 and raw >= pool and raw < pool + size and depth < most:
                    made = ptr32(raw)
                    kind = functions[child * FUNCTION_ROW + ENTRY_KIND] & 0xFF
                    if kind != _NATIVE and made[0] & ~GENERATOR == kind << KIND_SHIFT:
                        at = depth * WORK_ROW
                        work[at + WORK_SLOT] = raw + RAW_CODE * 4
                        work[at + WORK_FUNCTIONS] = int(functions)
                        work[at + WORK_NUMBER] = child
                        work[at + WORK_LAST] = child + 1
                        work[at + WORK_CHILDREN] = made[RAW_CHILDREN]
                        depth += 1
                child += tree


@micropython.viper
def locate(raw: ptr8, count: int, blocks: ptr32, functions: ptr32):
    """Where in flash the `count` functions of a file lie. `raw`: its table (host_tools/build/mpy.py); `blocks`: the addresses
    of its blocks, then 0. Code that crosses a block has none, nor have native code that is not aligned and what stays."""
    i = 0
    while i < count:
        offset = raw[0] | raw[1] << 8
        length = raw[2] | raw[3] << 8
        kind = raw[4]
        block = 0
        header = 0
        while blocks[block] and offset >= 4096 - header:
            offset -= 4096 - header
            block += 1
            header = 4
            n = block
            while n & 1 == 0:
                header += 4
                n >>= 1
        address = blocks[block]
        if address:
            address += header + offset
            if kind == 0 or header + offset + length > 4096 or (kind != 2 and address & 3):
                address = 0
        functions[ENTRY_FLASH] = address
        functions[ENTRY_BYTES] = length
        functions[ENTRY_KIND] = kind | raw[5] << 8 | (raw[6] | raw[7] << 8) << 16
        functions = ptr32(int(functions) + FUNCTION_ROW * 4)
        raw = ptr8(int(raw) + 8)
        i += 1


@micropython.viper
def largest(words: ptr32) -> int:
    """Bytes of the largest free piece; FREE gets the sum of all. In pieces of 64 as the collector's table has them, garbage
    not counted: 1 ms."""
    table = ptr8(words[TABLE])
    count = words[BLOCKS] >> 2
    most = 0
    run = 0
    free = 0
    i = 0
    while i < count:
        if table[i]:
            run = 0
        else:
            run += 64
            free += 64
            if run > most:
                most = run
        i += 1
    words[FREE] = free
    return most


@micropython.viper
def left(functions: ptr32, words: int) -> int:
    """How many bytes of a file's functions lie in flash and do not run from there yet. The first is not counted: it is the
    module itself, and garbage soon."""
    left = 0
    i = FUNCTION_ROW
    while i < words:
        if functions[i] and functions[i + ENTRY_BYTES] < 0x10000:
            left += functions[i + ENTRY_BYTES]
        i += FUNCTION_ROW
    return left


def trial(number):
    """For the trial: a function with a child."""

    def times(factor):
        return factor * 7 + 1

    return times(number) if number > 0 else times


def counted():
    """For the trial: a generator, which is left alone while it is suspended."""
    for number in (3, 4):
        yield number
