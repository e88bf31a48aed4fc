"""Kernels of flash_code.py: names that an earlier module had are given to the interpreter by their numbers.

    known = array("I", bytearray(KNOWN_BYTES))
    size = shorten(text, size << 16 | count, first, known)  # an .mpy's head in memory, `count` names from `first` on
    learn(flash, count << 16 | first, numbers, known)       # the same in flash, and the numbers that the interpreter has given them

The interpreter looks a name up among all, one after the other: 0.1 ms, six thousand times for a router. `known` has the address of each
name's text in flash, where its hash says, and behind all of them their numbers. A text ends with a zero.

    at = table_of_names(0x20000000, words)  # where the interpreter notes its newest table of names
    bound(at)                               # the next table has few entries

It makes tables one after the other, each twice as long as the one before: the last one may be empty but for a few names, 7 kB. Of
MicroPython 1.26 to 1.29 is known (py/qstr.h):

    qstr_pool_t          the table before, names in those before, entries, names, its hashes, its lengths; names' texts
"""

import micropython
from micropython import const

_SLOTS = const(2048)  # a power of two, more than there are names
_NUMBERS = const(8192)  # bytes before them
_COUNT = const(3072)  # where their count is, in words
_FULL = const(1900)
KNOWN_BYTES = const(12292)
_NEWEST = const(0)  # of the word that points to it
_ENTRIES = const(2)  # in a table of names
_USED = const(3)
_HASHES = const(4)
_LENGTHS = const(5)
_HEAD_BYTES = const(24)
_LEFT = const(40)  # entries: few modules have more new names
_HALF = const(96)  # of the entries of the next table


@micropython.viper
def slot_of(text: ptr8, length: int, known: ptr32) -> int:
    """Where a name is in `known`, or may go."""
    slot = length
    i = 0
    while i < length:
        slot = (slot * 33 ^ text[i]) & 0xFFFFFF
        i += 1
    slot = (slot ^ slot >> 11) & _SLOTS - 1
    while known[slot]:
        there = ptr8(known[slot])
        i = 0
        while i < length and there[i] == text[i]:
            i += 1
        if i == length and there[i] == 0:
            break
        slot = slot + 1 & _SLOTS - 1
    return slot


@micropython.viper
def head(text: ptr8, at: int) -> int:
    """What begins a name, and in the bits from 16 on where its text is: twice its length, or an odd number of the interpreter's own."""
    length = text[at]
    at += 1
    if length & 0x80:
        length = (length & 0x7F) << 7 | text[at]
        at += 1
    return at << 16 | length


@micropython.viper
def shorten(text: ptr8, sizes: int, first: int, known: ptr32) -> int:
    """Write the numbers of names in their place; returns how long the text is now. A number is 2 n + 1, in two bytes."""
    numbers = ptr16(int(known) + _NUMBERS)
    size = sizes >> 16
    count = sizes & 0xFFFF
    at = first
    end = first
    while count > 0:
        count -= 1
        begin = at
        length = int(head(text, at))
        at = length >> 16
        length &= 0xFFFF
        if length & 1 == 0:
            length >>= 1
            slot = int(slot_of(ptr8(int(text) + at), length, known))
            at += length + 1
            if known[slot]:
                number = numbers[slot] << 1 | 1
                text[end] = number >> 7 | 0x80
                end += 1
                text[end] = number & 0x7F
                end += 1
                begin = at
        while begin < at:
            text[end] = text[begin]
            end += 1
            begin += 1
    while at < size:
        text[end] = text[at]
        end += 1
        at += 1
    return end


@micropython.viper
def learn(text: ptr8, names: int, numbers: ptr16, known: ptr32):
    """Note the numbers of the names at `text`, names >> 16 of them from names & 0xFFFF on."""
    found = ptr16(int(known) + _NUMBERS)
    at = names & 0xFFFF
    count = names >> 16
    i = 0
    while i < count and known[_COUNT] < _FULL:
        length = int(head(text, at))
        at = length >> 16
        length &= 0xFFFF
        if length & 1 == 0:
            length >>= 1
            slot = int(slot_of(ptr8(int(text) + at), length, known))
            if known[slot] == 0:
                known[slot] = int(text) + at
                found[slot] = numbers[i]
                known[_COUNT] = known[_COUNT] + 1
            at += length + 1
        i += 1


@micropython.viper
def is_table(at: int) -> bool:
    """Whether a table of names as expected is at an address in memory."""
    if at & 15 or at < 0x20000000 or at > 0x2003FF00:
        return False
    table = ptr32(at)
    entries = table[_ENTRIES]
    if entries < 1 or entries > 4096 or table[_USED] > entries:
        return False
    if table[_HASHES] != at + _HEAD_BYTES + 4 * entries:
        return False
    return table[_LENGTHS] == table[_HASHES] + entries


@micropython.viper
def table_of_names(first: int, count: int) -> int:
    """The address of the first of `count` words that points to a table of names; 0: there is none."""
    words = ptr32(first)
    for i in range(count):
        if is_table(words[i]):
            return first + 4 * i
    return 0


@micropython.viper
def bound(at: int):
    """If the newest table is nearly full, let it look full, and short: the next one has twice as many entries as it says of itself."""
    if at:
        newest = ptr32(at)[_NEWEST]
        if is_table(newest):
            table = ptr32(newest)
            if table[_ENTRIES] > _HALF and table[_USED] >= _HALF and table[_ENTRIES] - table[_USED] < _LEFT:
                table[_ENTRIES] = _HALF
