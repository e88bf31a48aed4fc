"""Runs on the board, without the firmware: prints facts about the chip and times of its flash, a name and its values a line."""

import os
import sys
from binascii import hexlify
from time import ticks_us

import machine
import rp2
import vfs
from machine import mem32
from uctypes import addressof


def stamp_of(path):
    """Return the text of a stamp file, "" if there is none."""
    try:
        with open(path) as file:
            return file.read().strip()
    except OSError:
        return ""


flash = rp2.Flash()
size = addressof(flash) - 0x10000000 + flash.ioctl(4, 0) * flash.ioctl(5, 0)
print("chip", sys.implementation._machine)
print("revision", mem32[0x40000000] >> 28 & 15)
print("flash", size)
print("interpreter", sys.implementation.name, ".".join([str(part) for part in sys.implementation[1][:3]]))
print("id", str(hexlify(machine.unique_id()), "ascii"))
print("freq", machine.freq())
try:
    import passo_image as image

    print("uf2", image.CHIP, image.STAMP, image.VERSION)
    print("stamp", image.STAMP if image.whole() else "")
except ImportError:
    print("stamp", stamp_of("stamp.txt") if stamp_of("stamp.txt") == stamp_of("passo/stamp.txt") else "")
print("cause", machine.reset_cause())


class Timed:
    """The flash as littlefs sees it; lists the microseconds of each erase, and of each write by 256 bytes."""

    def __init__(self):
        self.erases = []
        self.pages = []

    def readblocks(self, *where):
        return flash.readblocks(*where)

    def writeblocks(self, block, data, offset=0):
        begun = ticks_us()
        flash.writeblocks(block, data, offset)
        self.pages.append((ticks_us() - begun) * 256 // max(len(data), 256))

    def ioctl(self, order, block):
        """Pass an order to the flash; note the time of each erase (order 6) in µs."""
        begun = ticks_us()
        done = flash.ioctl(order, block)
        if order == 6:
            self.erases.append(ticks_us() - begun)
        return done


def write():
    """Write 8 KiB to a file, then remove it."""
    with open("prove.tmp", "wb") as file:
        for _ in range(16):
            file.write(bytes(range(256)) * 2)
    os.remove("prove.tmp")


def measure_flash():
    """Mount the flash with times, write to it, mount it as before; print the times of erases and pages in µs."""
    timed = Timed()
    vfs.umount("/")
    try:
        vfs.mount(vfs.VfsLfs2(timed, progsize=256), "/")
        try:
            write()
        finally:
            vfs.umount("/")
    finally:
        vfs.mount(vfs.VfsLfs2(flash, progsize=256), "/")
    print("erases", *timed.erases)
    print("pages", *timed.pages)


measure_flash()
