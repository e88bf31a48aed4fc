"""One HTTP connection: a request in, read as it comes; an answer out, sent as the network takes it. Never waits.

    connection = Connection(socket, peer, now_ms)
    connection.receive()            # True once the request is whole: method, path, host, origin …
    connection.answer(200, b"text/plain", b"gone")
    connection.send()               # True once all of it has been sent

Of the head only what is looked at is kept. Whatever is longer than the bounds below, torn, or said twice sets `wrong`, the status
that answers it. A connection carries one request, which may make a WebSocket of it.
"""

from micropython import const

from passo.web.websocket import Frames, accept_of

HEAD = const(0)  # the states of a connection
BODY = const(1)
ASKED = const(2)  # the request is whole, the answer is not there
ANSWERED = const(3)
EVENTS = const(4)  # answered without an end: events follow
SOCKET = const(5)  # a WebSocket
READ = const(512)  # bytes a call
AGAIN = (11, 35, 10035)  # errors of a socket that has nothing, or no room
_SENT = const(1024)
_LINE = const(512)  # bytes of a line of the head
_HEAD_BYTES = const(4096)
_BODY_BYTES = const(256)
_MESSAGE_BYTES = const(1024)  # of a WebSocket's message
UNSENT = const(4096)  # bytes for a client that does not read
_STATUS = {
    200: b"OK", 400: b"Bad Request", 403: b"Forbidden", 404: b"Not Found", 405: b"Method Not Allowed",
    409: b"Conflict", 413: b"Content Too Large", 431: b"Request Header Fields Too Large", 503: b"Service Unavailable",
}  # fmt: skip
_HEADERS = (
    b"Connection: close\r\nCache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\n"
    b"Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' data:;"
    b" form-action 'self'; base-uri 'none'; frame-ancestors 'none'\r\n"
)


class Connection:
    def __init__(self, socket, peer, now_ms):
        """`socket` does not block; `peer`: the other end's address, a text."""
        self.socket = socket
        self.fd = socket.fileno() if hasattr(socket, "fileno") else None
        self.peer = peer
        self.since_ms = now_ms
        self.state = HEAD
        self.number = 0  # of its request, while ASKED
        self.wrong = 0
        self.method = self.path = b""
        self.body = b""
        self.host = self.origin = None
        self.proof = b""
        self.json = False
        self.key = None  # of a request for a WebSocket
        self.owner = None  # of a WebSocket: whom its messages are for
        self.page = None  # that owner's record of it
        self.heard_ms = now_ms
        self.asked = False  # for a sign of life
        self._upgrade = False
        self._frames = None
        self._length = None
        self._line = b""
        self._count = 0
        self._out = b""
        self._rest = []  # the parts after it: a board may have no piece of memory for the whole
        self._file = None
        self._left = 0  # bytes of it
        self.waits = False  # for room in the network
        self.taken_ms = now_ms  # when it was seen to have taken some

    # --- the request

    def receive(self):
        """Take the bytes received. Returns True if the request is whole, or wrong; of a WebSocket [(kind, bytes)], its messages. Raises OSError if
        the other end has gone, ValueError at bytes that are no WebSocket's."""
        try:
            data = self.socket.recv(READ)
        except OSError as error:
            if error.errno in AGAIN:  # nothing has come
                return ()
            raise
        if not data:
            raise OSError(0)
        if self.state == SOCKET:
            return self._frames.feed(data)
        self._count += len(data)
        if self.state == HEAD:
            data = self._read_head(data)
        if self.state == BODY:
            self._read_body(data)
        return self.state == ASKED

    def _read_head(self, data):
        """Read lines of the head. Returns the bytes behind it."""
        data = self._line + data
        while self.state == HEAD:
            end = data.find(b"\n")
            if end < 0 and len(data) <= _LINE:
                break
            if end < 0 or end > _LINE or self._count > _HEAD_BYTES:
                return self._refuse(431)
            line = data[:end].rstrip(b"\r")
            data = data[end + 1 :]
            if not self.method:
                self._read_first(line)
            elif line:
                self._read_field(line)
            elif (self._length or 0) > _BODY_BYTES:
                self._refuse(413)
            else:
                self.state = BODY
        self._line = data if self.state == HEAD else b""
        return data

    def _read_first(self, line):
        """Read the request line: method, path, and whether it asks for JSON."""
        parts = line.split(b" ")
        if len(parts) != 3 or parts[2] not in (b"HTTP/1.1", b"HTTP/1.0") or parts[1][:1] != b"/":
            self._refuse(400)
            return
        self.method = parts[0]
        path, _, query = parts[1].partition(b"?")
        self.path = path.replace(b"%2B", b"+")
        self.json = query == b"json"

    def _read_field(self, line):
        """Read a field of the head; fields that the server does not use are dropped."""
        name, colon, value = line.partition(b":")
        name = name.lower()
        value = value.strip()
        if not colon or name != name.strip():
            self._refuse(400)
        elif name == b"host" and self.host is None:
            self.host = value.lower()
        elif name == b"origin" and self.origin is None:
            self.origin = value.lower()
        elif name == b"content-length" and self._length is None and len(value) < 8 and value.isdigit():
            self._length = int(value)
        elif name in (b"host", b"origin", b"content-length", b"transfer-encoding"):
            self._refuse(400)
        elif name == b"upgrade":
            self._upgrade = value.lower() == b"websocket"
        elif name == b"sec-websocket-key":
            self.key = value
        elif name == b"accept":
            self.json = self.json or value.find(b"application/json") >= 0
        elif name == b"x-passo":
            self.proof = value

    def _read_body(self, data):
        """Read bytes of the body; the request is whole with Content-Length of them."""
        self.body += data
        length = self._length or 0
        if len(self.body) >= length:
            if len(self.body) > length:
                self.wrong = 400  # more than one request
            if not self._upgrade or self.method != b"GET":
                self.key = None
            self.state = ASKED

    def _refuse(self, status):
        self.wrong = status
        self.state = ASKED
        return b""

    # --- the answer

    def answer(self, status, kind, body, more=b"", path=None, start=0, size=0):
        """Send `body`, and behind it `size` bytes of the file `path` from `start` on. `kind`: its media type; `more`: lines of the
        head, each with its end."""
        if path:
            self._file = open(path, "rb")
            self._file.seek(start)
            self._left = size
        self._begin_answer(status, kind, more + b"Content-Length: %d\r\n" % (len(body) + size))
        if body:
            self._rest.append(body)
        self.state = ANSWERED

    def begin_events(self):
        """Answer with server-sent events from now on, see send_event()."""
        self._begin_answer(200, b"text/event-stream", b"")
        self.state = EVENTS

    def begin_socket(self, owner):
        """Make it a WebSocket; `owner` gets its messages."""
        self.owner = owner
        self._frames = Frames(_MESSAGE_BYTES)
        self.method = self.path = self.body = self.host = self.origin = self.proof = b""
        self._out = b"HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Accept: %s\r\n\r\n" % (
            accept_of(self.key)
        )
        self.state = SOCKET

    def send_event(self, data):
        """Send an event if the one before has been sent. Returns False if not."""
        if self._out or self._rest:
            return False
        self._out = b"data: " + data + b"\n\n"
        return True

    def _begin_answer(self, status, kind, more):
        self._out = b"HTTP/1.1 %d %s\r\nContent-Type: %s\r\n" % (status, _STATUS[status], kind)
        self._rest = [_HEADERS, more + b"\r\n"]

    def is_sending(self):
        return bool(self._out) or bool(self._rest) or self._file is not None

    def send(self, now_ms, data=b""):
        """Send as much as the network takes, `data` behind the rest. Returns True if bytes are left. Raises OSError if the other end has gone,
        or leaves more than UNSENT bytes."""
        if data:
            if len(self._out) + len(data) > UNSENT:
                raise OSError(0)
            self._out += data
        while self._out or self._rest or self._file is not None:
            if not self._out and self._rest:
                self._out = self._rest.pop(0)
            elif not self._out and self._file is not None:
                self._out = self._file.read(min(_SENT, self._left))
                self._left -= len(self._out)
                if not self._out or not self._left:
                    self._file.close()
                    self._file = None
            if self._out:
                try:
                    sent = self.socket.send(self._out if len(self._out) <= _SENT else self._out[:_SENT])
                    self._out = self._out[sent:] if sent < len(self._out) else b""
                    if sent:
                        self.taken_ms = now_ms
                except OSError as error:
                    if error.errno not in AGAIN:
                        raise
            if self._out or not self._rest:
                break
        if self._out or self._rest or self._file is not None:
            return True
        self.since_ms = now_ms
        return False

    def close(self):
        """Close the file and the socket."""
        if self._file is not None:
            self._file.close()
        self.socket.close()
