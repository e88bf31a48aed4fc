"""A language of lines over a TCP connection, or a WebSocket: lines that move the machine are signed with the key, one by one.

The board begins with `[PASSO:NONCE]`. A line is `COUNT.PROOF.BODY`, see session.py; BODY is a line of the language, or `*` and the two hex
digits of a real-time byte. Bytes that ask, or make the machine safe, are taken as they are, wherever they stand: `?`, `!`, 0x18, 0x84,
0x85. Anything else is answered by an error. `passo wifi bridge` is the other end: a pty for a sender. A server that serves the page takes
the same lines at /grbl by a WebSocket, in messages however they are cut.

One connection at a time. A new one takes the place of one that has proven nothing yet.
"""

from micropython import const

from passo import errors
from passo.web.connection import AGAIN, READ, UNSENT
from passo.web.guard import WRONG, make_nonce
from passo.web.session import Session
from passo.web.websocket import TEXT, frame

FREE = b"?!\x18\x84\x85"
_LINE = const(320)  # bytes of a line, with its proof
_JOG_CANCEL = FREE[-1:]


class SignedLine:
    browser = False  # a sender names no Origin

    def __init__(self, listener, key, server=None):
        """`listener`: a socket that listens, or None; `key`: text; `server`: of WebSockets (http.py), or None."""
        if listener:
            listener.setblocking(False)
        self._listener = listener
        self._key = key
        self._server = server
        if server:
            server.sockets[b"/grbl"] = self
        self._socket = self._connection = None  # one of them at most
        self._said = b""
        self._drop_connection()
        self._gone = False  # a connection has ended, and the language does not know yet

    def _drop_connection(self):
        """Close the connection, and forget its session and bytes."""
        if self._socket is not None:
            self._socket.close()
        connection = self._connection
        self._socket = self._session = self._connection = None
        if connection:
            self._server.drop(connection)
        self._line = self._out = b""
        self._wrong = 0
        self._gone = True

    def any(self):
        return False

    def read(self):
        """Return the received bytes that are proven or need no proof, for the language; b"": none."""
        said = self._said + (self._receive_bytes() if self._socket is not None else b"")
        self._said = b""
        self._accept_socket()  # after it: a client that has gone makes room
        if self._gone:
            self._gone = False
            said += _JOG_CANCEL  # a client's jog ends with its connection
        return said

    def _receive_bytes(self):
        """Send waiting bytes, and return the received bytes that are proven or need no proof."""
        self._send_rest()
        if self._socket is None:
            return b""
        data = b""
        try:
            data = self._socket.recv(READ)
        except OSError as error:
            if error.errno in AGAIN:
                return b""
        if not data:
            self._drop_connection()
            return b""
        return self._parse_bytes(data)

    def write(self, data):
        """Send the language's answer; lost without a connection."""
        if self._connection:
            self._server.send(self._connection, frame(TEXT, data))
        elif self._socket is not None and len(self._out) < UNSENT:
            self._out += bytes(data)
            self._send_rest()

    def select_list(self):
        return [socket for socket in (self._listener, self._socket) if socket]

    def close(self):
        """Close the connection, and stop to listen."""
        self._drop_connection()
        if self._listener:
            self._listener.close()

    def _accept_socket(self):
        """Accept a TCP connection, unless one has proven the key already."""
        try:
            socket, _ = self._listener.accept() if self._listener else (None, None)
        except OSError:
            return
        if socket is None:
            return
        if self._is_taken():
            socket.close()
            return
        socket.setblocking(False)
        greeting = self._begin_session()
        self._socket = socket
        self.write(greeting)

    def _is_taken(self):
        """True if there is a connection that has proven the key."""
        return self._session is not None and self._session.opened

    def _begin_session(self):
        """Begin a new session in the place of the one before. Returns its first bytes for the other end, with the nonce."""
        self._drop_connection()
        self._session = Session(self._key, make_nonce())
        return b"[PASSO:%s]\r\n" % self._session.nonce.encode()

    # --- as a WebSocket: see http.py

    def open(self, connection, now_ms):
        """Take a WebSocket, and return its first message; None: another connection has proven the key."""
        if self._is_taken():
            return None
        greeting = self._begin_session()
        self._connection = connection
        return frame(TEXT, greeting)

    def take_message(self, connection, data, now_ms):
        """Take the bytes of a WebSocket's message. Returns False if it is not the connection in use."""
        if len(self._said) + len(data) <= UNSENT:
            self._said += self._parse_bytes(data)
        return connection is self._connection

    def forget_connection(self, connection):
        """Forget the WebSocket that has ended."""
        if connection is self._connection:
            self._connection = None
            self._drop_connection()

    def _send_rest(self):
        """Send waiting bytes, as many as the network takes."""
        try:
            if self._out:
                self._out = self._out[self._socket.send(self._out) :]
        except OSError as error:
            if error.errno not in AGAIN:
                self._drop_connection()

    def _parse_bytes(self, data):
        """Return the bytes for the language: those that need no proof, and the bodies of whole lines with a right proof."""
        said = b""
        for byte in data:
            if byte in FREE:
                said += bytes((byte,))
            elif byte != 10:
                if len(self._line) <= _LINE:
                    self._line += bytes((byte,))
            else:
                said += self._body_of(self._line.rstrip(b"\r"))
                self._line = b""
                if self._session is None:
                    break
        return said

    def _body_of(self, line):
        """Return the body of a whole line that is signed, or b""."""
        try:
            body = self._session.open(line.decode()) if len(line) <= _LINE else None
        except ValueError:
            body = None
        if body is None:
            self._wrong += 1
            self.write(b"error:%d\r\n" % errors.NOT_ADMITTED)
            if self._wrong >= WRONG:
                self._drop_connection()
            return b""
        if body[:1] == "*":
            try:
                return bytes((int(body[1:], 16) & 0xFF,))
            except ValueError:
                return b""
        return body.encode() + b"\n"
