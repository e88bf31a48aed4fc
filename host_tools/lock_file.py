"""Files that one process at a time has locked: for a port's URL, and for the link of a virtual board.

    descriptor = open_lock(path)        # to be locked by flock

They lie where others may write, too: no link is followed, and nobody else can open them.
"""

import errno
import os
import stat


def open_lock(path):
    """Return the descriptor of a file of this user's that only this user may open; made if there is none. Raises OSError with the file's name if
    something else lies there."""
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW | os.O_NONBLOCK, 0o600)
    try:
        found = os.fstat(descriptor)
        if not stat.S_ISREG(found.st_mode) or found.st_uid != os.geteuid():
            raise OSError(errno.EACCES, os.strerror(errno.EACCES), str(path))
        os.fchmod(descriptor, 0o600)
    except OSError:
        os.close(descriptor)
        raise
    return descriptor
