"""Moves code by half a word, so that two halves of neighbouring instructions no longer make a word that the collector takes for a pointer.

    text = shift_functions(text, {"steps_pace_viper_pace"})     # C with a nop at the beginning of these functions
    names = functions_at(elf, base, {0x1234})           # the functions in which these bytes of the code lie
"""

import re
import struct

_SYMBOLS, _FUNCTION = 2, 2  # kinds of a section and of a symbol


def shift_functions(text, names):
    for name in names:
        text = re.sub(rf"^(\w[^;\n]*\b{name}\([^;\n]*\) {{)$", r'\1 __asm volatile("nop");', text, count=1, flags=re.MULTILINE)
    return text


def functions_at(elf, base, offsets):
    """Return the names of the functions of an ELF whose code has any of these bytes, counted from `base`."""
    found = set()
    for name, begin, length in _functions_of(elf):
        if any(begin - base <= offset < begin - base + length for offset in offsets):
            found.add(name)
    return found


def sections(elf):
    """Return [(kind, flags, address, offset in the file, length, link)] of an ELF's sections."""
    wide = elf[4] == 2
    (offset,) = struct.unpack_from("<Q" if wide else "<I", elf, 40 if wide else 32)
    size, count = struct.unpack_from("<HH", elf, 58 if wide else 46)
    form = "<IIQQQQI" if wide else "<IIIIIII"
    return [struct.unpack_from(form, elf, offset + size * each)[1:] for each in range(count)]


def _functions_of(elf):
    """Yield (name, address, length) of each function of an ELF of 32 bits."""
    found = sections(elf)
    for kind, _, _, offset, length, link in found:
        if kind == _SYMBOLS:
            names = found[link][3]
            for at in range(offset, offset + length, 16):
                name, address, extent, info = struct.unpack_from("<IIIB", elf, at)
                if info & 15 == _FUNCTION:
                    text = elf[names + name : elf.index(b"\0", names + name)].decode()
                    yield text.partition(".")[0], address & ~1, extent
