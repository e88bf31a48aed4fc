"""The page's files where they are frozen, as a file system that can only be read.

    vfs.mount(FrozenFiles({"pages.bin": b"…"}), "/page")
"""

from io import BytesIO


class FrozenFiles:
    def __init__(self, files):
        self._files = files

    def mount(self, readonly, mkfs):
        pass

    def umount(self):
        pass

    def ilistdir(self, path):
        return iter([(name, 0x8000, 0, len(data)) for name, data in self._files.items()])

    def stat(self, path):
        return 0x8000, 0, 0, 0, 0, 0, len(self._bytes_of(path)), 0, 0, 0

    def open(self, path, mode):
        """Open a file for reading; its bytes are not copied. Raises OSError (2) if there is none."""
        return BytesIO(self._bytes_of(path))

    def _bytes_of(self, path):
        try:
            return self._files[path.lstrip("/")]
        except KeyError:
            raise OSError(2)
