"""Kernels of flash_code.py: names that an earlier module had are given to the interpreter by their numbers.

    known = array("I", bytearray(KNOWN_BYTES))
    look(0x20000000, words, known)                          # where the interpreter notes its names
    size = shorten(text, size << 16 | count, first, known)  # an .mpy's head in memory, `count` names from `first` on
    learn(flash, count << 16 | first, numbers, known)       # the same in flash, and the numbers that the interpreter has given them

The interpreter looks a name up among all, one after the other: 0.1 ms, six thousand times for a router. `known` has the address of each
name's text in flash, where its hash says, and behind all of them their numbers. A text ends with a zero.

    take(known, address, size)              # texts of new names go into this piece of memory
    move(known, address, target)            # those that are left there go elsewhere; 0: returns how many bytes that takes

It copies the texts of new names one behind the other into a piece of memory, 14 kB for a router. `learn` lets a name's text be the one
in flash, and the piece end where it did before the module was loaded: few stay.

It makes tables one after the other, each twice as long as the one before: the last one may be empty but for a few names, 7 kB. `shorten` has the
next one begin with few entries, and so does

    limit_next_table(known, new)            # for as many names

Of MicroPython 1.26 to 1.29 is known (py/qstr.h, py/mpstate.h):

    qstr_pool_t          the table before, names in those before, entries, names, its hashes, its lengths; names' texts
    mp_state_vm_t        …, the piece of memory for texts, its bytes, how many are used, …
"""

import micropython
from micropython import const

_SLOTS = const(2048)  # a power of two, more than there are names
_NUMBERS = const(8192)  # bytes before them
_COUNT = const(3072)  # the index of their count, in words
_TABLES = const(3073)  # the address of the word that points to the newest table; 0: unknown
_PIECE = const(3074)  # the same of the piece of memory for texts
_FROM = const(3075)  # the address of the first text of the module that is being loaded; 0: they stay in their places
_FULL = const(1900)
KNOWN_BYTES = const(12304)
_NEWEST = const(0)  # of the word that points to it
_BEFORE = const(0)  # in a table of names: the one before it, and how many names those before it have
_EARLIER = const(1)
_COUNTED = const(0xFFFFFF)  # beside their number is a mark, its highest bit
_ENTRIES = const(2)
_USED = const(3)
_HASHES = const(4)
_LENGTHS = const(5)
_TEXTS = const(6)
_TEXT = const(0)  # of the word that points to it
_BEGIN = const(0)  # of a piece of memory: its address, its bytes, how many are used
_BYTES = const(1)
_END = const(2)
_HEAD_BYTES = const(24)
_LEFT = const(4)  # entries that stay free behind a module
_HALF = const(96)  # of the entries of the next table


@micropython.viper
def slot_of(text: ptr8, length: int, known: ptr32) -> int:
    """Return the slot of a name in `known`, or a free one for it."""
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
    """Return the first value of a name, and in the bits from 16 on the offset of its text: twice its length, or an odd number of the interpreter's own."""
    length = text[at]
    at += 1
    if length & 0x80:
        length = (length & 0x7F) << 7 | text[at]
        at += 1
    return at << 16 | length


@micropython.viper
def start_of_texts(known: ptr32) -> int:
    """Return the address at which texts of the module that is to be loaded will begin: its path, the first of its names, is there already.
    0: they stay where they go."""
    if known[_PIECE] == 0:
        return 0
    piece = ptr32(known[_PIECE])
    table = ptr32(ptr32(known[_TABLES])[_NEWEST])
    last = _TEXTS + table[_USED] - 1
    start = table[last]
    if start <= piece[_BEGIN] or start >= piece[_BEGIN] + piece[_END]:  # the first text of a piece stays, so that the collector keeps it
        return 0
    return start


@micropython.viper
def limit_next_table(known: ptr32, new: int):
    """Let the newest table, if it has no room for `new` names, look full and short: the next one has twice as many entries as it says of itself."""
    if known[_TABLES]:
        newest = ptr32(known[_TABLES])[_NEWEST]
        if is_table(newest):
            table = ptr32(newest)
            if table[_ENTRIES] > _HALF and table[_USED] >= _HALF and table[_ENTRIES] - table[_USED] < new + _LEFT:
                table[_ENTRIES] = _HALF


@micropython.viper
def shorten(text: ptr8, sizes: int, first: int, known: ptr32) -> int:
    """Write the numbers of names in their place; returns how long the text is now. A number is 2 n + 1, in two bytes. The interpreter's table has
    room for the others then."""
    numbers = ptr16(int(known) + _NUMBERS)
    size = sizes >> 16
    count = sizes & 0xFFFF
    at = first
    end = first
    new = 0
    known[_FROM] = int(start_of_texts(known))
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
            else:
                new += 1
        while begin < at:
            text[end] = text[begin]
            end += 1
            begin += 1
    while at < size:
        text[end] = text[at]
        end += 1
        at += 1
    limit_next_table(known, new)
    return end


@micropython.viper
def text_of(number: int, known: ptr32) -> int:
    """Return the address of the word that points to a name's text, in one of the interpreter's tables in memory."""
    table = ptr32(ptr32(known[_TABLES])[_NEWEST])
    while number < table[_EARLIER] & _COUNTED:
        table = ptr32(table[_BEFORE])
    return int(table) + 4 * (_TEXTS + number - (table[_EARLIER] & _COUNTED))


@micropython.viper
def end_of_texts(known: ptr32) -> int:
    """Return the address at which texts of the module that has been loaded end; before _FROM if they begin in another piece of memory."""
    if known[_FROM] == 0:
        return 0
    piece = ptr32(known[_PIECE])
    if piece[_BEGIN] > known[_FROM]:
        return 0
    return piece[_BEGIN] + piece[_END]


@micropython.viper
def learn(text: ptr8, names: int, numbers: ptr16, known: ptr32):
    """Note the numbers of the names at `text`, names >> 16 of them from names & 0xFFFF on; the texts of new ones are no longer in memory."""
    found = ptr16(int(known) + _NUMBERS)
    begin = known[_FROM]
    end = int(end_of_texts(known))
    left = end - begin
    at = names & 0xFFFF
    count = names >> 16
    i = 0
    while i < count:
        length = int(head(text, at))
        at = length >> 16
        length &= 0xFFFF
        if length & 1 == 0:
            length >>= 1
            slot = int(slot_of(ptr8(int(text) + at), length, known))
            if known[slot] == 0 and known[_COUNT] < _FULL:
                known[slot] = int(text) + at
                found[slot] = numbers[i]
                known[_COUNT] = known[_COUNT] + 1
            if begin < end:
                there = ptr32(text_of(numbers[i], known))
                if there[_TEXT] >= begin and there[_TEXT] < end:
                    there[_TEXT] = int(text) + at
                    left -= length + 1
            at += length + 1
        i += 1
    if begin < end and left == 0:
        ptr32(known[_PIECE])[_END] = begin - ptr32(known[_PIECE])[_BEGIN]


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
def is_piece(piece: ptr32, end: int) -> bool:
    """Whether a piece of memory as expected is noted there: its used part ends with the newest name."""
    used = piece[_END]
    if used < 1 or used > piece[_BYTES] or piece[_BYTES] > 0xFFFF:
        return False
    return piece[_BEGIN] + used == end


@micropython.viper
def look(first: int, count: int, known: ptr32):
    """Look among `count` words for the interpreter's table of its names."""
    words = ptr32(first)
    for i in range(count):
        if is_table(words[i]):
            known[_TABLES] = first + 4 * i
            break
    if known[_TABLES]:
        table = ptr32(ptr32(known[_TABLES])[_NEWEST])
        newest = table[_USED] - 1
        end = table[_TEXTS + newest] + ptr8(table[_LENGTHS])[newest] + 1
        for i in range(count):
            if is_piece(ptr32(first + 4 * i), end):
                known[_PIECE] = first + 4 * i


@micropython.viper
def take(known: ptr32, first: int, size: int):
    """Texts of new names go into a piece of `size` bytes from now on. If it is full, the interpreter makes one of its own, and frees what
    is left of this one."""
    if known[_PIECE]:
        piece = ptr32(known[_PIECE])
        piece[_BEGIN] = first
        piece[_BYTES] = size
        piece[_END] = 0


@micropython.viper
def move(known: ptr32, begin: int, target: int) -> int:
    """Copy the texts in a piece to `target`, one behind the other; the interpreter makes one of its own for new ones then. Returns how many
    bytes. None are copied if they go into another piece already."""
    if known[_PIECE] == 0:
        return 0
    piece = ptr32(known[_PIECE])
    end = begin + piece[_END]
    if piece[_BEGIN] != begin:
        return 0
    if target:
        piece[_BEGIN] = 0
    moved = 0
    table = ptr32(ptr32(known[_TABLES])[_NEWEST])
    while int(table) >= 0x20000000:  # others are the interpreter's own, in flash
        i = 0
        while i < table[_USED]:
            text = table[_TEXTS + i]
            if text >= begin and text < end:
                length = ptr8(table[_LENGTHS])[i] + 1
                if target:
                    table[_TEXTS + i] = target + moved
                    j = 0
                    while j < length:
                        ptr8(target)[moved + j] = ptr8(text)[j]
                        j += 1
                moved += length
            i += 1
        table = ptr32(table[_BEFORE])
    return moved
