"""The sum over the words of the UF2's image: see passo_image."""

import sys

import micropython


@micropython.viper
def total(first: int, count: int) -> int:
    """Of `count` words from an address on. 800 kB take some 50 ms, most of them the flash's."""
    words = ptr32(first)
    found = 0
    for index in range(count):
        found = found * 31 + words[index]
    return found & 0x3FFFFFFF


def keep_known():
    """Put the interpreter's own modules into sys.modules. Else each `import` of one searches the file system first, 0.1 s in all."""
    import array
    import binascii
    import io
    import machine
    import os
    import select
    import struct
    import time

    for module in (array, binascii, io, machine, os, select, struct, time):
        sys.modules[module.__name__] = module
