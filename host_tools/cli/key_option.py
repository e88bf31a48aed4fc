"""The keys that a verb of `passo` is given, or keeps in a file.

    key_of(text, "PASSO_KEY")           # as page_key.read_key() has it. Raises Failure if it is too short
    key_in(path), make_key_file(path)   # of a file that other users cannot read
    read_secret(path)                   # its first line, a password
"""

import os

from host_tools.clients import page_key
from host_tools.failure import Failure, reason


def key_of(text, where):
    """Return the key in `text`. Raises Failure if it is wrong: the message names the source of the text, `where`, never the text itself."""
    try:
        return page_key.read_key(text)
    except ValueError:
        raise Failure("{}: a key has 16 or more of these letters and digits: {}", where, page_key.KEY_LETTERS) from None


def key_in(path):
    """Return the key in a file. Raises Failure if it is wrong, or other users may read the file."""
    return key_of(read_secret(path), path)


def make_key_file(path):
    """Write a new key to a file of this user's only, unless there is one. Raises Failure."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with open(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as file:
            file.write(page_key.make_key(os.urandom) + "\n")
    except FileExistsError:
        pass
    except OSError as error:
        raise Failure("cannot write {}: {}", path, reason(error)) from error


def read_secret(path):
    """Return the first line of a file. Raises Failure if there is none, or other users may read the file."""
    try:
        if os.name == "posix" and path.stat().st_mode & 0o077:
            raise Failure("others can read {}: chmod 600 {}", path, path)
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise Failure("cannot read {}: {}", path, reason(error)) from error
    if not lines or not lines[0]:
        raise Failure("{}: its first line is no password", path)
    return lines[0]
