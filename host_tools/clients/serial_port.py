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


frames = None  # `passo --frames`, `--no-frames`: ask every board for frames, or none


class LinkError(Failure):
    """The port, the wire or the device at its other end failed."""


def open_link(port, baud, slice_s, text):
    """As open_exclusively(), without old input; a FramedPort if the board has frames. It is asked if the language is of lines, each answered
    by one (`text`), or if `frames` says so; then for longer, as the wire may be bad."""
    from host_tools.clients.frames import SURE_S, offered

    opened = open_exclusively(port, baud, slice_s)
    try:
        opened.reset_input_buffer()
        if text if frames is None else frames:
            opened = offered(opened, SURE_S, text, True) if frames else offered(opened, text=text)
            opened.reset_input_buffer()
        return opened
    except OSError as error:
        opened.close()
        raise LinkError("port {} went away: {}", port, reason(error)) from error


def open_exclusively(port, baud, slice_s):
    """Open a device, a pty or any pyserial URL such as socket://host:port; one read waits `slice_s`. Returns a pyserial port.
    Raises LinkError; if another program has the port, it names that program."""
    import serial

    lock = None
    try:
        if "://" in str(port):
            lock = _lock_of_url(str(port))
            opened = serial.serial_for_url(port, baudrate=baud, timeout=slice_s, write_timeout=5)
            _closed_with(opened, lock)
        else:
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


def _lock_file(url):
    name = hashlib.sha256(url.encode()).hexdigest()[:16]
    return Path(tempfile.gettempdir()) / f"passo-{name}.lock"


def _lock_of_url(url):
    """The descriptor of a locked file that stands for `url`. Raises OSError (EAGAIN) if it is locked."""
    try:
        import fcntl
    except ImportError:
        return None
    descriptor = os.open(_lock_file(url), os.O_RDWR | os.O_CREAT, 0o666)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(descriptor)
        raise
    return descriptor


def _closed_with(opened, lock):
    """Give the lock up when the port is closed."""
    close = opened.close

    def close_both():
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
                found.append(f"{_command(process)} (process {process.name})")
        except OSError:
            continue  # gone by now, or of another user
    return " and ".join(found)


def _command(process):
    """What a person typed, roughly: without the interpreter and its folders."""
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
