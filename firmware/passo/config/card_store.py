"""Stored jobs on a memory card. FAT replaces no file at once, so nothing is renamed here: a power cut between two writes could
lose a file, or leave two names for one.

A job is in one of two files, NAME.job or NAME.alt, in the form of job_store.py, and one byte more. An upload goes to the one
that is free. It counts once that last byte is there: it is written when the upload has been read back, right and whole. Then the
other file goes. If both count, the power was cut in between: either is whole, and one of them is used. An upload that was cut off is
shorter than its first line says, or has none: it is removed. A file whose first line is wrong is damaged, and stays.
"""

import os

from micropython import const

from passo.config.job_store import HEAD_BYTES, JobStore, parse_first_line

_ENDS = ".job", ".alt"
END_MARK = b"\n"
_TORN = const(1)  # an upload that was cut off
_DAMAGED = const(2)  # its first line is wrong: it stays, and is told
_COUNTS = const(3)


def _state(path):
    """Whether a file counts; 0 if there is none, or a folder."""
    try:
        with open(path, "rb") as file:
            line = file.readline(HEAD_BYTES)
        size = os.stat(path)[6]
    except OSError:
        return 0
    head = parse_first_line(line)
    if head is None:
        return _DAMAGED if size >= HEAD_BYTES or line[-1:] == b"\n" else _TORN
    return _TORN if size < len(line) + head[3] + len(END_MARK) else _COUNTS


class CardStore(JobStore):
    _is_flash = False

    def mount(self):
        """A card has been put in, or the power has come back: make the folder, and remove uploads that were cut off."""
        JobStore.mount(self)
        for name in os.listdir(self._folder[:-1]):
            if name[-4:] in _ENDS and _state(self._folder + name) == _TORN:
                os.remove(self._folder + name)

    def names(self):
        return self._names(_ENDS)

    def _path(self, name):
        path = self._folder + name + _ENDS[1]
        other = self._other(path)
        state = _state(path)
        return path if state and state >= _state(other) else other

    def delete(self, name):
        path = self._path(name)
        os.remove(path)
        self._remove(self._other(path))

    def _other(self, path):
        return path[:-4] + _ENDS[path.endswith(_ENDS[0])]

    def _place(self, name):
        path = self._path(name)
        return self._other(path) if _state(path) == _COUNTS else path

    def keep(self):
        path = self._upload
        with open(path, "ab") as file:
            file.write(END_MARK)
        self._upload = ""
        self._remove(self._other(path))

    def abort(self):
        JobStore.abort(self)
        self._upload = ""
