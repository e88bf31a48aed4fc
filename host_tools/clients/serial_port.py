"""Opens a serial port for one program only.

    opened = open_exclusively("/dev/ttyACM0", 57600, 0.05)      # a pyserial port
    opened = open_link("/dev/ttyACM0", 57600, 0.05, True)       # the same, or frames on it if the board has them

A port is locked with flock, as pyserial and mpremote do. A real serial device is also locked with TIOCEXCL, which stops
programs that do not use flock; flock also stops root, whom TIOCEXCL does not. A URL such as socket://host:port is locked by a
file in the folder for temporary files: its server would drop the first client for the second.
"""

import errno
import hashlib
import os
import tempfile
from pathlib import Path

from host_tools.failure import Failure, reason
from host_tools.language import _
from host_tools.lock_file import open_lock


_SLICE_S = 0.05  # how long one read of open_port()'s waits: the finest grain of every time-out
frames = None  # `passo --frames`, `--no-frames`: ask every board for frames, or none


class LinkError(Failure):
    """The port, the wire or the device at its other end failed."""


def port_error(port, error):
    """A LinkError for an open port that went away."""
    if str(port).startswith("socket://"):
        return LinkError("{} hung up: the board has ended, or another program has taken the connection ({})", port, reason(error))
    return LinkError("port {} went away: {}", port, reason(error))


def open_link(port, baud, slice_s, text):
    """Open a port as open_exclusively() does, drop old input, and return a FramedPort if the board has frames. The board is asked for frames if its
    language has lines, each answered by one (`text`), or if `frames` is set; then it is asked for longer, because the wire may be bad. Raises
    LinkError."""
    from host_tools.clients.frames import SURE_S, offer_frames

    opened = open_exclusively(port, baud, slice_s)
    try:
        opened.reset_input_buffer()
        if text if frames is None else frames:
            plain = opened
            opened = offer_frames(plain, SURE_S, text, True) if frames else offer_frames(plain, text=text)
            if frames and opened is plain:
                plain.close()
                raise LinkError("the board on {} answers no frames: leave --frames out, or give its link the key in the board file", port)
            opened.reset_input_buffer()
        return opened
    except OSError as error:
        opened.close()
        raise port_error(port, error) from error


def open_port(port, baud):
    """Open a port for this program only. Asks for frames only if `passo --frames` is given: controllers older than Passo take any bytes for
    packets. Raises LinkError."""
    return open_link(port, baud, _SLICE_S, False)


def open_exclusively(port, baud, slice_s):
    """Open a device, a pty or any pyserial URL such as socket://host:port; one read waits `slice_s`. Returns a pyserial port.
    Raises LinkError; if another program has the port, it names that program."""
    import serial

    lock = None
    try:
        if "://" in str(port):
            lock = _lock_of_url(str(port))
            opened = serial.serial_for_url(port, baudrate=baud, timeout=slice_s, write_timeout=5)
            _release_lock_with(opened, lock)
        else:
            _refuse_left_link(str(port))
            opened = serial.serial_for_url(port, baudrate=baud, timeout=slice_s, write_timeout=5, exclusive=True)
            _keep_others_out(opened)
        return opened
    except (serial.SerialException, ValueError, OSError) as error:
        if lock is not None:
            os.close(lock)
        number = getattr(error, "errno", None)
        if number in (errno.EAGAIN, errno.EBUSY, errno.EACCES) and (others := _users_of(port)):
            raise LinkError("port {} is in use by {}", port, others) from error
        if number in (errno.EAGAIN, errno.EBUSY):
            raise LinkError("port {} is in use by another program", port) from error
        raise LinkError("cannot open port {}: {}", port, _(os.strerror(number)) if number else error) from error


def _keep_others_out(opened):
    """Set TIOCEXCL, which ends when the device is closed; not on a pty, where it would outlive a killed program."""
    try:
        import fcntl
        import termios

        if not os.path.realpath(opened.port).startswith("/dev/pts/"):
            fcntl.ioctl(opened.fileno(), termios.TIOCEXCL)
    except (ImportError, AttributeError, OSError, ValueError):
        pass  # not every device can: flock is enough


def _refuse_left_link(port):
    """Raise LinkError if `port` is the symlink of a virtual board that was killed: its pty may be another board's by now."""
    path = Path(port)
    lock = path.with_name(f".{path.name}.lock")
    if not path.is_symlink() or not lock.is_file():
        return
    import fcntl

    try:
        descriptor = open_lock(lock)
    except OSError:
        return  # another user's board
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return  # its board has it
    else:
        raise LinkError("the link {} was left by a board that was killed: it leads nowhere, or to another board. Start the board again", port)
    finally:
        os.close(descriptor)


def _lock_file(url):
    name = hashlib.sha256(url.encode()).hexdigest()[:16]
    return Path(tempfile.gettempdir()) / f"passo-{os.getuid() if hasattr(os, 'getuid') else 0}-{name}.lock"


def _lock_of_url(url):
    """The descriptor of a locked file that stands for `url`. Raises OSError (EAGAIN) if it is locked."""
    try:
        import fcntl
    except ImportError:
        return None
    descriptor = open_lock(_lock_file(url))
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(descriptor)
        raise
    return descriptor


def _release_lock_with(opened, lock):
    """Have the port's close() release the lock."""
    close = opened.close

    def close_both():
        """Close the port, then its lock file; a second call leaves the lock alone."""
        nonlocal lock
        close()
        if lock is not None:
            os.close(lock)
            lock = None

    opened.close = close_both


def _users_of(port):
    """The other programs that have `port` open, as far as this user may see them: "passo draw map.svg (process 1234)"."""
    wanted = str(_lock_file(str(port))) if "://" in str(port) else os.path.realpath(port)
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        if process.name == str(os.getpid()):
            continue
        try:
            if any(os.path.realpath(each) == wanted for each in (process / "fd").iterdir()):
                found.append(f"{_command_line(process)} (process {process.name})")
        except OSError:
            continue  # gone by now, or of another user
    return " and ".join(found)


def _command_line(process):
    """The command line of a process without the interpreter and its folders, 80 letters at most. `process`: its folder in /proc."""
    words = (process / "cmdline").read_bytes().decode("utf-8", "replace").split("\0")
    words = [word for word in words if word]
    if words and Path(words[0]).name.startswith("python"):
        del words[0]
        while words and words[0].startswith("-") and words[0] not in ("-c", "-m"):
            del words[: 2 if words[0] in ("-W", "-X") else 1]
        del words[: {"-c": 2, "-m": 1}.get(words[0], 0) if words else 0]
    if words:
        words[0] = {"host_tools.cli": "passo"}.get(words[0], Path(words[0]).name)
    return " ".join(words)[:80] or "another program"
