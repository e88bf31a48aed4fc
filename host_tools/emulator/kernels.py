"""Finds and names the firmware's machine-code functions in an emulated Pico's memory.

    kernels = Kernels(symbols, ram, flash)      # `profile.Symbols` of the UF2 that runs, the two memories
    kernels.name_of(0x2002dd14)                    # 'passo.steps.segment.cut', or None
    kernels.starts                              # [(address, name)]

Function objects are recognised by their type. A function's name is that of the dictionary entry that points to it; its module's
name is the `__name__` beside it. Assembler functions have no module. Layouts: MicroPython 1.23 to 1.28 on 32 bits.
"""

import bisect
import struct

_RAM, _FLASH = 0x20000000, 0x10000000
_TYPES = ("mp_type_fun_viper", "mp_type_fun_native", "mp_type_fun_asm")
_POOLS = ("mp_qstr_frozen_const_pool", "mp_qstr_const_pool")
_QSTR_TAG, _QSTR = 7, 2  # the low bits of an object that is an interned string
_LENGTH_BITS = 0x7FFFFFFF


class Kernels:
    def __init__(self, symbols, ram, flash):
        self._ram, self._flash = bytes(ram), bytes(flash)
        self._words = struct.unpack(f"<{len(self._ram) // 4}I", self._ram)
        self._pools = self._find_pools(next(symbols.objects[name] for name in _POOLS if name in symbols.objects))
        found = {}
        for index, address, code, context in self._find_functions({symbols.objects.get(name): name for name in _TYPES}):
            names = self._names_of(_RAM + 4 * index)
            module = self._module_of(context) if context else ""
            found[code] = ".".join(filter(None, (module, max(names, key=len) if names else "?")))
        self.starts = sorted(found.items())
        self._addresses = [address for address, _ in self.starts]

    def name_of(self, address):
        """Return the name of the kernel whose code has `address`; None if it lies before all."""
        index = bisect.bisect_right(self._addresses, address) - 1
        return self.starts[index][1] if index >= 0 else None

    def _read_bytes(self, address, count):
        memory, start = (self._ram, _RAM) if address >= _RAM else (self._flash, _FLASH)
        return memory[address - start : address - start + count]

    def _read_word(self, address):
        data = self._read_bytes(address, 4) if address >= _FLASH else b""
        return int.from_bytes(data, "little") if len(data) == 4 else 0

    # --- functions

    def _find_functions(self, types):
        """Yield (index of its word, address, address of its code, of its module's context or 0) of each function object."""
        types.pop(None, None)
        for index in range(0, len(self._words) - 4, 4):  # blocks of the heap are 16 bytes
            kind = types.get(self._words[index])
            if kind:
                assembly = kind == "mp_type_fun_asm"
                code = self._words[index + (2 if assembly else 3)]
                if _RAM <= code < _RAM + len(self._ram):
                    yield index, _RAM + 4 * index, code & ~1, 0 if assembly else self._words[index + 1]

    def _names_of(self, function):
        """Return the names under which any dictionary in memory holds the object at address `function`; the first call reads all of memory."""
        if not hasattr(self, "_by_value"):
            self._by_value = {}
            for index in range(len(self._words) - 1):
                if self._words[index] & _QSTR_TAG == _QSTR and self._words[index + 1] >= _RAM:
                    self._by_value.setdefault(self._words[index + 1], []).append(self._words[index] >> 3)
        names = (self._qstr_text(number) for number in self._by_value.get(function, ()))
        return [name for name in names if name]

    def _module_of(self, context):
        """Return the name of the module of a context, which begins with the module: an object of its type and its globals."""
        table = self._read_word(self._read_word(context + 4) + 12)
        for entry in range(table, table + 8 * 64, 8):
            key, value = self._read_word(entry), self._read_word(entry + 4)
            if key & _QSTR_TAG == value & _QSTR_TAG == _QSTR and self._qstr_text(key >> 3) == "__name__":
                return self._qstr_text(value >> 3)
        return ""

    # --- interned strings

    def _find_pools(self, address):
        """Return [(first number, how many, address)] of the pools of names. In flash each knows the one before it; those in RAM are searched for."""
        pools, last = [], address
        while address:
            pools.append(self._read_pool(address))
            address = self._read_word(address)
        while True:
            first, count, _ = self._read_pool(last)
            following = [
                _RAM + 4 * index
                for index in range(len(self._words) - 1)
                if self._words[index] == last and self._words[index + 1] & _LENGTH_BITS == first + count
            ]
            if not following:
                return pools
            last = following[0]
            pools.append(self._read_pool(last))

    def _read_pool(self, address):
        return self._read_word(address + 4) & _LENGTH_BITS, self._read_word(address + 12), address

    def _qstr_text(self, number):
        """Return the text of an interned string by its number, "" if no pool has it."""
        for first, count, pool in self._pools:
            if first <= number < first + count:
                index = number - first
                length = self._read_bytes(self._read_word(pool + 20) + index, 1)[0]
                return self._read_bytes(self._read_word(pool + 24 + 4 * index), length).decode(errors="replace")
        return ""
