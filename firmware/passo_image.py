"""Frozen into Passo's UF2 beside the package: its contents, the check that all of it is in the flash, and the choice of the package to run.

    passo_image.whole()         # False: the UF2 was not copied to its end, or the flash has lost a bit
    passo_image.choose_package()        # True: the frozen package; False: the one on the file system, which `passo flash --source` laid there

The page of the flash before the file system has the length of the image, and the sum over its words.
"""

import sys

# The build says these.
STAMP = None
CHIP = None
VERSION = None
MARK = None
SOURCE = "source.txt"  # names the stamp of a package on the file system that is to run


def whole():
    """Return True if the flash holds the whole image, by the record in its last 256 bytes: mark, length and sum. Always True on an ESP32."""
    if CHIP == "esp32":
        return True  # its boot loader starts no image whose sum is wrong
    import rp2
    import uctypes

    from passo.ports.rp2 import clock
    from passo.ports.rp2.image import keep_known, total

    keep_known()
    clock.hurry()  # here already: outputs are safe the sooner
    end = uctypes.addressof(rp2.Flash())
    record = [int.from_bytes(uctypes.bytearray_at(end - 256 + 4 * field, 4), "little") for field in range(4)]
    mark, first, count, found = record
    return mark == MARK and first + 4 * count <= end and total(first, count) == found


def text_of(path):
    try:
        with open(path) as file:
            return file.read().strip()
    except OSError:
        return ""


def choose_package():
    """Sets where modules are looked for. Says so if there is another package on the file system."""
    if STAMP is None:
        return False  # not built: this is the source
    there = text_of("passo/stamp.txt")
    if there and there == text_of(SOURCE):
        return False
    if there:
        print("the package in /passo, build %s, is not run: build %s is in the UF2 (passo flash --source runs modules of yours)" % (there, STAMP))
    sys.path.remove(".frozen")
    sys.path.insert(0, ".frozen")
    return True
