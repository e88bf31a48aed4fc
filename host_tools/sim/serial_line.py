"""Virtual serial lines: the board's end of a link, on a PC.

    line = PtyLine(link="/tmp/plotter")     # any serial program opens line.name, or the link
    line = TcpLine(5000)                    # pyserial opens line.name: socket://127.0.0.1:5000
    data = line.read()                      # b"" if nothing has come; never waits
    line.write(b"k")
    wait_for_bytes([line], 5)                         # until a byte may have come, or 5 ms

Clients may connect again and again. Bytes that the board sends while there is none are lost, as on a real line.
"""

import contextlib
import errno
import fcntl
import os
import select
import socket
import subprocess
import sys
import termios
import time
import tty
from pathlib import Path

from host_tools import interpreter
from host_tools.failure import Failure, reason
from host_tools.language import _
from host_tools.lock_file import open_lock
from host_tools.sim.gate import Gate

READ_BYTES = 4096
UNSENT_BYTES = 1 << 20  # kept for a client that does not read; beyond that the oldest are lost, with a message
# Removes a link once the board that made it was killed: the next pty may have the same name. The lock says that nobody has made the link anew.
_REMOVE = """
import fcntl, os, sys
link, target, lock = sys.argv[1:]
sys.stdin.buffer.read()
try:
    fcntl.flock(os.open(lock, os.O_RDWR | os.O_NOFOLLOW), fcntl.LOCK_EX | fcntl.LOCK_NB)
    if os.readlink(link) == target:
        os.unlink(link)
    os.unlink(lock)
except OSError:
    pass
"""


def wait_for_bytes(lines, milliseconds):
    """Sleep until one of `lines` may have something to read, or the time is over."""
    watched = [fd for line in lines for fd in line.select_list()]
    if watched:
        select.select(watched, [], [], milliseconds / 1000)
    else:
        time.sleep(milliseconds / 1000)


class _Line:
    consent = None  # nobody is asked: consent.py

    def __init__(self):
        self.name = ""
        self._unsent = b""
        self._told = False  # that bytes are lost

    def write(self, data):
        """Send bytes, and keep those that the client does not take: the last UNSENT_BYTES, with one warning."""
        self._unsent += bytes(data)
        self._send_unsent()
        if len(self._unsent) > UNSENT_BYTES:
            self._unsent = self._unsent[-UNSENT_BYTES:]
            if not self._told:
                self._told = True
                text = _("{}: its client does not read; what the board says to it is lost", self.name)
                print(text, file=sys.stderr, flush=True)

    def _send_unsent(self):
        """Send what the client takes now; without a client forget it."""
        while self._unsent:
            try:
                sent = self._send_some(self._unsent)
            except BlockingIOError:
                return
            except OSError:
                sent = len(self._unsent)
            self._unsent = self._unsent[sent:]


class PtyLine(_Line):
    """A pseudo-terminal in raw mode: bytes pass unchanged. `link`: a symlink to make; replaces a stale one. Raises Failure if
    another board has it: the symlink belongs to the holder of the lock on .LINK.lock beside it. If this program is killed, another
    one removes the symlink."""

    def __init__(self, link=None):
        super().__init__()
        self._fd, slave = os.openpty()
        self._path = os.ttyname(slave)
        os.close(slave)
        os.set_blocking(self._fd, False)
        self._open = True  # a client has the other end open
        self._link = Path(link) if link else None
        self._lock = self._remover = None
        self.name = str(link) if link else self._path
        self._hung_up()
        if self._link:
            try:
                self._make_link()
            except Failure:
                os.close(self._fd)
                raise

    def read(self):
        """Return the bytes that have come, at most READ_BYTES, b"" if none; send bytes that still wait."""
        try:
            data = os.read(self._fd, READ_BYTES)
            self._open = True
        except BlockingIOError:
            data = b""
            self._open = True
        except OSError as error:
            if error.errno != errno.EIO:
                raise
            data = b""
            if self._open:
                self._hung_up()
        if self._unsent:
            self._send_unsent()
        return data

    def select_list(self):
        return [self._fd] if self._open else []  # a closed pty is always ready, with nothing to read

    def close(self):
        """Remove the link if it is still this line's, free its lock, and close the pty."""
        if self._link:
            if self._link.is_symlink() and os.readlink(self._link) == self._path:
                self._link.unlink()
            if self._lock:
                self._lock.release_lock()
            if self._remover:
                self._remover.communicate()
        os.close(self._fd)

    def _send_some(self, data):
        return os.write(self._fd, data) if self._open else len(data)

    def _hung_up(self):
        """The client has gone: make the line raw for the next one, without answers to this one."""
        self._open = False
        self._unsent = b""
        slave = os.open(self._path, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(slave)
        termios.tcflush(slave, termios.TCIFLUSH)
        os.close(slave)

    def _make_link(self):
        """Make the link to the pty, locked, and a process that removes it after this one's end. Raises Failure."""
        try:
            self._lock = Lock(self._link.with_name(f".{self._link.name}.lock"))
            if not self._lock.taken:
                raise Failure("another board has the link {}: end it first, or choose another name", self._link)
            if self._link.is_symlink():
                self._link.unlink()
            self._link.symlink_to(self._path)
            words = [self._link.absolute(), self._path, self._lock.path.absolute()]
            # In a session of its own: Ctrl-C and the end of a terminal are not for it.
            self._remover = subprocess.Popen([*interpreter.python(), "-S", "-c", _REMOVE, *words], stdin=subprocess.PIPE, start_new_session=True)
        except OSError as error:
            if self._lock:
                self._lock.release_lock()
            where = f"{error.filename}: " if self._lock is None and error.filename else ""
            raise Failure("cannot make the link {}: {}", self._link, where + reason(error)) from error


class Lock:
    """A file that one process at a time has locked. It ends with the process, however that ends; `taken`: we have it."""

    def __init__(self, path):
        self.path = path
        self._fd = open_lock(path)
        try:
            fcntl.flock(self._fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
            # The former holder may have removed the file since it was opened: then this lock is on a file without a name.
            self.taken = _is_same_file(self._fd, path)
        except BlockingIOError:
            self.taken = False
        if not self.taken:
            os.close(self._fd)

    def release_lock(self):
        """Remove the lock file and free the lock, if it is taken."""
        if self.taken:
            self.path.unlink(missing_ok=True)
            os.close(self._fd)
            self.taken = False


def _is_same_file(fd, path):
    """True if `fd` is open on the file that `path` names now."""
    try:
        return os.path.samestat(os.fstat(fd), os.lstat(path))
    except FileNotFoundError:
        return False


class _Client:
    """One connection of a TcpLine, with its Gate against browsers."""

    def __init__(self, client):
        client.setblocking(False)
        self.address = "{}:{}".format(*client.getpeername()[:2])
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.socket, self.gate = client, Gate()

    def read(self, name):
        """Bytes for the board; None: it has hung up, or has been hung up on."""
        try:
            data = self.socket.recv(READ_BYTES)
            if not data:
                return None
        except BlockingIOError:
            data = b""
        except OSError:
            return None
        if data or self.gate.has_bytes():
            data = self.gate.filter_bytes(data, time.monotonic())
            if data is None:
                print(_("{}: hung up on a client that is no sender", name), file=sys.stderr, flush=True)
        return data


TAKEN = {"grbl": b"[MSG:%s has taken this connection]\r\n", "pulses": b"taken:%s\n"}  # by language; the others never speak unasked


class TcpLine(_Line):
    """A TCP server on this machine with one client at a time. A new client takes the place of the old with the first byte that the gate lets pass:
    connections of browsers, and those refused from the first line on, are hung up on (gate.py), and the old one goes on. Port 0: any. `message`:
    sent to the client that loses the line, with the address of the new one; b"": its language has no word for it. The loss is also printed, and
    `taken(address of the loser)` is called, which writes the log that each language's status reads."""

    def __init__(self, port, host="127.0.0.1", message=b"", taken=None):
        super().__init__()
        self._message = message
        self.taken = taken
        try:
            self._server = socket.create_server((host, port))
        except (OSError, OverflowError) as error:
            raise Failure("cannot serve TCP port {}: {}", port, reason(error)) from error
        self._server.setblocking(False)
        self._client = None
        self._coming = None  # the last that has connected, and said nothing yet, beside _client
        self.clients = 0  # connections so far
        self.name = f"socket://{host}:{self._server.getsockname()[1]}"

    def read(self):
        """Return the bytes that have come, b"" if none; a new client replaces the present one with its first bytes."""
        self._accept_client()
        data = b""
        if self._coming:
            data = self._coming.read(self.name)
            if data is None:
                self._coming.socket.close()
                self._coming = None
            elif data:
                self._switch_client()
        if self._client and not data:
            data = self._client.read(self.name)
            if data is None:
                self._switch_client()
        if self._unsent:
            self._send_unsent()
        return data or b""

    def write(self, data):
        if self._client:
            self._client.gate.note_answer(bytes(data))
        super().write(data)

    def select_list(self):
        return [self._server] + [client.socket for client in (self._client, self._coming) if client]

    def close(self):
        """Close the clients' sockets and the server."""
        for client in (self._client, self._coming):
            if client:
                client.socket.close()
        self._client = self._coming = None
        self._server.close()

    def _accept_client(self):
        """Accept a new client, if there is one; it waits for its first bytes while another is served."""
        try:
            coming = _Client(self._server.accept()[0])
        except OSError:  # nobody is there, or gone already
            return
        if self._coming:
            self._coming.socket.close()
        self._coming = coming
        if not self._client:
            self._switch_client()

    def _switch_client(self):
        """The one that comes, if any, is the client now."""
        if self._client and self._coming:
            print(_("{}: the program at {} has taken the place of the one at {}", self.name, self._coming.address, self._client.address), file=sys.stderr, flush=True)
            if self._message:
                with contextlib.suppress(OSError):
                    self._client.socket.send(self._message % self._coming.address.encode())
            if self.taken:
                self.taken(self._client.address)
        if self._client:
            self._client.socket.close()
        self._unsent = b""
        self._client, self._coming = self._coming, None
        self.clients += bool(self._client)

    def _send_some(self, data):
        return self._client.socket.send(data) if self._client else len(data)
