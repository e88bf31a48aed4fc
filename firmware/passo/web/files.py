"""The files that a server sends: those of one folder, by names that are there. No text from a network reaches the file system.

    files = Folder("passo/web/page/")
    files.find_file(b"/panel.js")    # (media type, lines of the head, path, start, bytes); None: there is no such file

A board has most of them in one file, `pages.bin`, because each file takes a block of 4 kB of its flash: lines `NAME BYTES`, the last one
empty, then the files one after the other, compressed with gzip. They are sent as they are; every browser takes that.
"""

import os

_KINDS = {
    "html": b"text/html; charset=utf-8", "js": b"text/javascript; charset=utf-8", "css": b"text/css; charset=utf-8",
    "svg": b"image/svg+xml", "json": b"application/json",
}  # fmt: skip
PACK = "pages.bin"
_FIRST = "index.html"


class Folder:
    def __init__(self, path):
        """`path`: with a slash at its end."""
        self.path = path
        names = os.listdir(path)
        self._names = [name for name in names if name.split(".")[-1] in _KINDS]
        self._packed = {}  # name: (start, bytes)
        if PACK in names:
            self._read_pack()

    def _read_pack(self):
        """Read the table of pages.bin: start and size of each file."""
        with open(self.path + PACK, "rb") as file:
            start = 0
            while True:
                line = file.readline()
                name, _, size = line.decode().strip().partition(" ")
                if not name:
                    break
                self._packed[name] = (start, int(size))
                start += int(size)
            head = file.tell()
        for name in self._packed:
            start, size = self._packed[name]
            self._packed[name] = (start + head, size)

    def find_file(self, path):
        """(media type, lines of the head, path, start, bytes) of the file that a request's path names; None: there is none."""
        try:
            name = path[1:].decode() or _FIRST
        except ValueError:
            return None
        kind = _KINDS.get(name.split(".")[-1])
        if name in self._packed:
            start, size = self._packed[name]
            return kind, b"Content-Encoding: gzip\r\n", self.path + PACK, start, size
        if name in self._names:
            return kind, b"", self.path + name, 0, self.file_size(name)
        return None

    def file_size(self, name):
        """Bytes of a file that is not packed."""
        return os.stat(self.path + name)[6]
