"""A bridge to a board's grbl over its network: a sender's bytes in the clear here, proven lines there.

    bridge = Bridge("passo.local", 23, key, line)       # line: host_tools.sim.serial_line's PtyLine or TcpLine
    while True:
        bridge.carry_bytes(100)                         # at most 100 ms

The other end is passo/web/signed.py, which describes the bytes.
"""

import select
import socket

from host_tools.failure import Failure, reason
from passo.web.session import Hmac
from passo.web.signed import FREE

_CONNECT_S = 5
_READ = 4096
_LONGEST = 4096  # bytes of a sender's line


class Bridge:
    def __init__(self, host, port, key, line):
        """`key`: as page_key.read_key gives it. Raises Failure if no board of Passo answers there."""
        self._hmac = Hmac(key.encode())
        self._line = line
        self._count = 0
        self._typed = b""
        self._rest = b""
        try:
            self._socket = socket.create_connection((host, port), _CONNECT_S)
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._nonce = self._read_greeting()
        except OSError as error:
            raise Failure("no board answers at {}, port {}: {}", host, port, reason(error)) from error

    def _read_greeting(self):
        """Read the board's first line, and return its nonce, bytes. Raises Failure if it is another server, or hangs up."""
        while b"\n" not in self._rest:
            data = self._socket.recv(_READ)
            if not data:
                raise Failure("the board has hung up: does another sender use it?")
            self._rest += data
        first, _, self._rest = self._rest.partition(b"\n")
        first = first.strip()
        if not first.startswith(b"[PASSO:") or not first.endswith(b"]"):
            raise Failure("this is no board of Passo")
        return first[7:-1]

    def carry_bytes(self, milliseconds):
        """Carry bytes both ways; wait for them at most `milliseconds`. Raises Failure when the board hangs up."""
        if self._rest:
            self._line.write(self._rest)
            self._rest = b""
        ready, _, _ = select.select([self._socket, *self._line.select_list()], [], [], milliseconds / 1000)
        try:
            data = self._socket.recv(_READ) if self._socket in ready else None
            typed = self._line.read()
            if typed:
                self._socket.sendall(self._prove_bytes(typed))
        except OSError as error:
            raise Failure("the board has hung up: {}", reason(error)) from error
        if data == b"":
            raise Failure("the board has hung up: is it the right key?")
        if data:
            self._line.write(data)

    def _prove_bytes(self, data):
        """Return a sender's bytes as lines with proofs for the board; the real-time bytes in FREE stay as they are."""
        out = b""
        for byte in data:
            if byte in FREE:
                out += bytes((byte,))
            elif byte >= 0x80 or byte == 0x7E:
                out += self._prove_line(b"*%02x" % byte)
            elif byte in b"\r\n":
                if self._typed or byte == 10:
                    out += self._prove_line(self._typed)
                self._typed = b""
            elif len(self._typed) < _LONGEST:
                self._typed += bytes((byte,))
        return out

    def _prove_line(self, body):
        """Return the line as the board takes it, bytes: count, HMAC of nonce, count and body in hex, and body, joined by dots."""
        self._count += 1
        count = b"%d" % self._count
        proof = self._hmac.hex_digest(self._nonce + b"." + count + b"." + body).encode()
        return count + b"." + proof + b"." + body + b"\n"

    def close(self):
        self._socket.close()
