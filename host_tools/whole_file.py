"""Writing a file whole, or not at all.

    write_whole(path, data)     # bytes. Raises OSError; then the file is what it was

A name that stands in its way as a link is replaced, never followed: it may be in a folder of others.
"""

import os
import shutil
import tempfile

_MODE = 0o644


def write_whole(path, data):
    """Write `data` to a new file that replaces `path` at once; an old file's mode stays, a new one's is 644. Raises OSError."""
    descriptor, made = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with open(descriptor, "wb") as file:
            file.write(data)
        os.chmod(made, _MODE)
        if path.is_file() and not path.is_symlink():
            shutil.copymode(path, made)
        os.replace(made, path)
    except OSError:
        os.unlink(made)
        raise
