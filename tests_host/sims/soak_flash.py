"""A small flash file system in memory, for the board's stored jobs: it gets full, and a power cut tears what is being written.

    flash = Flash(64 * 1024)
    flash.mount()               # the file system of config/job_store.py, until
    flash.unmount()
    flash.cut_after(1000)       # 1000 bytes more, then PowerCut
"""

import errno
import io
import os

from host_tools.sim.pages import PowerCut
from passo.options.jobs import config as job_store

BLOCK = 4096


class _Writer:
    def __init__(self, flash, path):
        self._flash, self._path = flash, path
        flash.files[path] = bytearray()

    def write(self, data):
        for byte in bytes(data):
            self._flash.put(self._path, byte)

    def close(self):
        pass


def _name(path):
    """There is one folder."""
    return path.rsplit("/", 1)[-1]


class Flash:
    """Functions of `os` that the job store calls, and open()."""

    def __init__(self, size=64 * 1024, files=None):
        self.size = size
        self.files = dict(files or {})
        self._left = None

    def mount(self):
        job_store.os = self
        job_store.open = self.open

    @staticmethod
    def unmount():
        job_store.os = os
        vars(job_store).pop("open", None)

    def cut_after(self, count):
        self._left = count

    def used(self):
        return sum([-(-len(data) // BLOCK) + 1 for data in self.files.values()]) * BLOCK

    def put(self, path, byte):
        if self._left is not None:
            if not self._left:
                raise PowerCut
            self._left -= 1
        if len(self.files[path]) % BLOCK == 0 and self.used() + BLOCK > self.size:
            raise OSError(errno.ENOSPC, "full")
        self.files[path].append(byte)

    def open(self, path, mode):
        if mode == "wb":
            return _Writer(self, _name(path))
        if _name(path) not in self.files:
            raise OSError(errno.ENOENT, path)
        return io.BytesIO(self.files[_name(path)])

    def mkdir(self, folder):
        """It is there."""

    def listdir(self, folder):
        return list(self.files)

    def remove(self, path):
        if _name(path) not in self.files:
            raise OSError(errno.ENOENT, path)
        del self.files[_name(path)]

    def rename(self, old, new):
        self.files[_name(new)] = self.files.pop(_name(old))

    def sync(self):
        """Nothing is held back."""

    def statvfs(self, folder):
        free = (self.size - self.used()) // BLOCK
        return BLOCK, BLOCK, self.size // BLOCK, free, max(free, 0), 0
