"""Packages of npm's registry, one version of one checksum each, kept in ~/.cache/passo.

    files = MICROPYTHON.read_files("micropython.mjs", "micropython.wasm")        # {name: bytes}
"""

import base64
import hashlib
import io
import os
import tarfile
import urllib.error
import urllib.request
from dataclasses import dataclass
from pathlib import Path

from host_tools.failure import Failure

_MOST = 8 << 20  # bytes of an archive
_FETCH_S = 60


@dataclass
class Package:
    """A package of npm's registry, one version of one checksum."""

    what: str  # its name for people
    name: str  # with its @scope/
    version: str
    integrity: str  # SHA-512, base64

    @property
    def _file_name(self):
        """Return the name of the archive in the registry."""
        return f"{self.name.rpartition('/')[2]}-{self.version}.tgz"

    def path_in(self, cache=None):
        """Return the path of its archive in the cache, a folder (None: ~/.cache/passo)."""
        return (cache or Path("~/.cache/passo").expanduser()) / self._file_name

    def read_files(self, *names, cache=None):
        """Return {name: bytes} of some of its files, fetched the first time. Raises Failure if it cannot be fetched, or is not the one that
        is known."""
        kept = self.path_in(cache)
        if kept.is_file():
            data = kept.read_bytes()
        else:
            data = self._fetch_archive()
            kept.parent.mkdir(parents=True, exist_ok=True)
            fresh = kept.with_suffix(f".{os.getpid()}")
            fresh.write_bytes(data)
            os.replace(fresh, kept)
        try:
            return self.extract_files(data, names)
        except Failure:
            kept.unlink(missing_ok=True)
            raise

    def _fetch_archive(self):
        """Return the bytes of the archive from the registry (NPM_CONFIG_REGISTRY). Raises Failure after 60 s."""
        registry = os.environ.get("NPM_CONFIG_REGISTRY", "https://registry.npmjs.org").rstrip("/")
        address = f"{registry}/{self.name}/-/{self._file_name}"
        try:
            with urllib.request.urlopen(address, timeout=_FETCH_S) as answer:
                return answer.read(_MOST)
        except (OSError, urllib.error.URLError) as error:
            raise Failure("cannot fetch {}, {}: {}", self.what, address, error) from error

    def extract_files(self, data, names):
        """Return {name: bytes} of files of an archive. Raises Failure if its SHA-512 is not the known one."""
        found = base64.b64encode(hashlib.sha512(data).digest()).decode()
        if found != self.integrity:
            raise Failure(
                "{} {} is not what it was: SHA-512 {} instead of {}; it is not used",
                self.name, self.version, found, self.integrity,
            )
        with tarfile.open(fileobj=io.BytesIO(data)) as archive:
            return {name: archive.extractfile(f"package/{name}").read() for name in names}
