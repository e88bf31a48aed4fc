"""A UF2 file: blocks of 512 bytes (github.com/microsoft/uf2), each with three magic numbers, its place, and which chip it is for.

    data = blocks_of([(0x10000000, page), …], FAMILIES["rp2040"])
    is_whole(data)
"""

import struct
from pathlib import Path

CACHE = Path("~/.cache/passo").expanduser()
BLOCK_BYTES = 512
MAGIC_START, MAGIC_SECOND, MAGIC_END = 0x0A324655, 0x9E5D5157, 0x0AB16F30
FAMILY_PRESENT = 0x2000
FAMILIES = {"rp2040": 0xE48BFF56, "rp2350": 0xE48BFF59}
FLASH = 0x10000000
PAGE = 256  # of the flash, and of a block


def blocks_of(pages, family):
    """Return the bytes of a UF2 file. `pages`: (address, 256 bytes at most) each; `family`: the chip's number, of FAMILIES."""
    out = bytearray()
    for number, (address, data) in enumerate(pages):
        out += struct.pack("<8I", MAGIC_START, MAGIC_SECOND, FAMILY_PRESENT, address, PAGE, number, len(pages), family)
        out += data.ljust(BLOCK_BYTES - 36, b"\0") + struct.pack("<I", MAGIC_END)
    return bytes(out)


def is_whole(data):
    """True if all blocks are there that a file says it has."""
    count = len(data) // BLOCK_BYTES
    for at in range(0, len(data), BLOCK_BYTES):
        words = struct.unpack_from("<8I", data, at) if len(data) - at >= BLOCK_BYTES else ()
        if words[:2] != (MAGIC_START, MAGIC_SECOND) or words[6] != count:
            return False
    return count > 0
