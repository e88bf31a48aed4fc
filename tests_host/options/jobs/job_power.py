"""The power goes while a job is stored, at any write of the flash or card: run by test_job_power.py under MicroPython.

    micropython job_power.py lfs | fat

A file system of MicroPython's own on a device in memory. The write at which the power goes is torn: of a block of flash only a
part has been erased or programmed; of a card, which writes a sector whole, nothing. Then the file system is mounted anew.
"""

import gc
import sys
import vfs
from binascii import crc32

from check_jobs import stored_form
from passo.options.jobs import config as job_store
from passo.options.jobs.config import JobStore

JobStore.root = "/flash/"
OLD = b"G1X1F100\n" * 60
NEW = b"G1X2F200\n" * 600  # more than a block
OTHER = b"G1X3F300\n" * 50
FLASH = 4096, 24
CARD = 512, 128


class Nothing:
    """Collects no garbage."""

    def collect(self):
        pass


class Cut(Exception):
    """The power has gone."""


class Device:
    def __init__(self, block_bytes, blocks):
        self.data = bytearray(b"\xff" * (block_bytes * blocks))
        self._block_bytes = block_bytes
        self._blocks = blocks
        self.torn = 0  # cut a write after this many 256ths of it; 0: before it begins
        self.left = -1  # writes until the power goes

    def readblocks(self, number, view, offset=0):
        if self.left == 0:
            raise Cut
        begin = number * self._block_bytes + offset
        view[:] = self.data[begin : begin + len(view)]

    def _write(self, begin, data):
        if self.left == 0:
            raise Cut
        self.left -= 1
        if self.left == 0:
            data = data[: len(data) * self.torn >> 8]
        self.data[begin : begin + len(data)] = data
        if self.left == 0:
            raise Cut

    def writeblocks(self, number, data, offset=None):
        self._write(number * self._block_bytes + (offset or 0), data)

    def ioctl(self, what, number):
        if what == 4:
            return self._blocks
        if what == 5:
            return self._block_bytes
        if what == 6:
            self._write(number * self._block_bytes, b"\xff" * self._block_bytes)
        return 0


def store(jobs, name, data):
    packed = stored_form(data)
    jobs.begin(name, "grbl", len(data), crc32(data), len(packed))
    for first in range(0, len(packed), 54):
        assert jobs.add_data(packed[first : first + 54]) == 0
    upload = jobs.open_upload()
    assert read(upload) == data
    jobs.commit_upload()


def read(job):
    """Return the bytes that a job reads. Raises Damaged."""
    view = memoryview(bytearray(126))
    parts = []
    count = job.readinto(view)
    while count:
        parts.append(bytes(view[:count]))
        count = job.readinto(view)
    job.close()
    return b"".join(parts)


def names(jobs):
    return [entry[0] for entry in jobs.list_jobs()]


def opened(store):
    jobs = store("/flash/jobs")
    jobs.mount()
    return jobs


def cut_at(system, store_class, device, image, writes, torn, name):
    """Store NEW as `name`, the power gone with the write number `writes`. Returns whether it was cut."""
    device.data[:] = image
    device.torn = torn
    device.left = writes
    cut = False
    try:
        vfs.mount(system(device), "/flash")
        store(opened(store_class), name, NEW)
    except Cut:
        cut = True
    device.left = -1
    vfs.umount("/flash")
    vfs.mount(system(device), "/flash")
    jobs = opened(store_class)
    before = {"A": OLD, "B": OTHER}
    found = {kept: read(jobs.open(kept)) for kept in names(jobs)}
    wanted = before.copy()
    wanted[name] = NEW
    assert found == wanted or cut and found == before, (writes, torn, name, sorted(found))
    store(jobs, name, NEW)  # and all goes on
    assert names(jobs) == sorted(wanted)
    assert read(jobs.open(name)) == NEW
    vfs.umount("/flash")
    return cut


def full(system, store_class, device, image):
    """An upload that finds no room leaves what was there, and the room it took."""
    device.data[:] = image
    vfs.mount(system(device), "/flash")
    jobs = opened(store_class)
    before = jobs.free_bytes()
    for name in ("A", "C"):
        jobs.begin(name, "grbl", 10, 0, 1 << 20)
        try:
            while True:
                jobs.add_data(bytes(500))
        except OSError:
            jobs.abort_upload()
        assert names(jobs) == ["A", "B"] and jobs.free_bytes() == before, (names(jobs), jobs.free_bytes(), before)
        assert read(jobs.open("A")) == OLD and read(jobs.open("B")) == OTHER
    vfs.umount("/flash")


def main(kind):
    if kind == "lfs":
        system, store_class, geometry = vfs.VfsLfs2, JobStore, FLASH
    else:
        from passo.options.card.config import CardStore

        system, store_class, geometry = vfs.VfsFat, CardStore, CARD
    gc.disable()  # files that a power cut has left open would be closed, and written
    job_store.gc = Nothing()
    device = Device(*geometry)
    system.mkfs(device)
    vfs.mount(system(device), "/flash")
    jobs = opened(store_class)
    store(jobs, "A", OLD)
    store(jobs, "B", OTHER)
    vfs.umount("/flash")
    image = bytes(device.data)
    cuts = 0
    for name in ("A", "B", "C"):
        for torn in (0, 100, 255) if kind == "lfs" else (0,):
            writes = 1
            while cut_at(system, store_class, device, image, writes, torn, name):
                writes += 1
                cuts += 1
    full(system, store_class, device, image)
    print("%d power cuts, nothing lost" % cuts)


main(sys.argv[1])
