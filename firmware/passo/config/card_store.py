"""Stored jobs on a memory card. FAT replaces no file at once, so nothing is renamed here: a power cut between two writes could
lose a file, or leave two names for one.

A job is in one of two files, NAME.job or NAME.alt, in the form of job_store.py, and one byte more. An upload goes to the one
that is free. It counts once that last byte is there: it is written when the upload has been read back, right and whole. Then the
other file goes. If both count, the power was cut in between: either is whole, and one of them is used.
"""

import os

from passo.config.job_store import HEAD_BYTES, JobStore

_ENDS = ".job", ".alt"
END_MARK = b"\n"


def _counts(path):
    """True if a file is whole."""
    try:
        with open(path, "rb") as file:
            line = file.readline()[:HEAD_BYTES]
        return os.stat(path)[6] == len(line) + int(line.split()[4]) + len(END_MARK)
    except (OSError, IndexError, ValueError):
        return False


class CardStore(JobStore):
    _is_flash = False

    def mount(self):
        """A card has been put in, or the power has come back: make the folder, and remove uploads that were cut off."""
        JobStore.mount(self)
        for name in os.listdir(self._folder[:-1]):
            if name[-4:] in _ENDS and not _counts(self._folder + name):
                os.remove(self._folder + name)

    def names(self):
        return sorted({name[:-4] for name in os.listdir(self._folder[:-1]) if name[-4:] in _ENDS})

    def _path(self, name):
        path = self._folder + name + _ENDS[1]
        return path if _counts(path) else self._folder + name + _ENDS[0]

    def delete(self, name):
        path = self._path(name)
        os.remove(path)
        self._remove(self._other(path))

    def _other(self, path):
        return path[:-4] + _ENDS[path.endswith(_ENDS[0])]

    def _place(self, name):
        path = self._path(name)
        return self._other(path) if _counts(path) else path

    def keep(self):
        path = self._upload
        with open(path, "ab") as file:
            file.write(END_MARK)
        self._upload = ""
        self._remove(self._other(path))

    def abort(self):
        JobStore.abort(self)
        self._upload = ""
