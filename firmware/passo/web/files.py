"""The files that a server sends: those of one folder, by names that are there. Nothing that a network says reaches the file system.

    files = Folder("passo/web/page/")
    files.find(b"/panel.js")    # (media type, lines of the head, path); None: there is no such file

A board has them compressed, `panel.js.gz`: it sends them as they are, and every browser takes that.
"""

import os

_KINDS = {
    "html": b"text/html; charset=utf-8", "js": b"text/javascript; charset=utf-8", "css": b"text/css; charset=utf-8",
    "svg": b"image/svg+xml", "json": b"application/json",
}  # fmt: skip
_PACKED = ".gz"
_FIRST = "index.html"


class Folder:
    def __init__(self, path):
        """`path`: with a slash at its end."""
        self.path = path
        self._names = [name for name in os.listdir(path) if name.replace(_PACKED, "").split(".")[-1] in _KINDS]

    def find(self, path):
        try:
            name = path[1:].decode() or _FIRST
        except ValueError:
            return None
        kind = _KINDS.get(name.split(".")[-1])
        if name + _PACKED in self._names:
            return kind, b"Content-Encoding: gzip\r\n", self.path + name + _PACKED
        return (kind, b"", self.path + name) if name in self._names and kind else None
