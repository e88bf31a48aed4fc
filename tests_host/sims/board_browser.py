"""A router on a virtual port that serves the page itself, and a browser in the same loop: real sockets, stepped time.

    board = ServedRouter()
    page = board.page()                     # a WebSocket, and the key
    page.order("step", by={"x": 1}, speed=500)      # the answer, a dict
    board.run_ms(300)
    page.state, page.pushes

Small enough for MicroPython.
"""

import json
import socket

from passo.web.connection import AGAIN
from passo.web.session import Session
from router import Machine

KEY = "ABCDEFGHJKLMNPQR"
TICKS_PER_MS = 12_500
LINKS = [
    {"name": "pc", "port": "uart0", "tx": 0, "rx": 1, "protocol": "grbl"},
    {"name": "page", "port": "page", "protocol": "grbl"},
    {"name": "wifi", "port": "tcp", "protocol": "grbl"},
]
PAGE = __file__[: __file__.rfind("tests_host/")] + "firmware/passo/web/page/"
_NODELAY = (6, 1, 1)  # MicroPython has no names for it
_FIRST_PORT = 18_080
_PORTS = 2000
_MASK = b"\x11\x82\x03\xf4"
_ANSWERED_MS = 3000


class Here:
    """The radio: a free port of this PC."""

    key = KEY
    names = (b"127.0.0.1", b"passo.local")
    folder = PAGE
    _next = 0

    def __init__(self):
        self.address = {}

    def is_own_peer(self, peer):
        return True

    def listen(self, kind):
        for _ in range(_PORTS):
            Here._next = (Here._next + 37) % _PORTS
            made = socket.socket()
            made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            made.setsockopt(*_NODELAY)  # connections inherit it
            address = socket.getaddrinfo("127.0.0.1", _FIRST_PORT + Here._next, 0, socket.SOCK_STREAM)[0][-1]
            try:
                made.bind(address)
                made.listen(64)
            except OSError:
                made.close()
                continue
            self.address[kind] = address
            return made
        raise OSError(98)


class ServedRouter(Machine):
    def __init__(self, **changes):
        self.radio = Here()
        self.browsers = []
        changes.setdefault("network", {"host": "passo"})
        Machine.__init__(self, radio=self.radio, links=LINKS, **changes)
        self.server = self.app.links[1].serial
        self.run_ms(20)

    def now_ms(self):
        return self.port.now / TICKS_PER_MS

    def connect(self, kind="http"):
        wire = socket.socket()
        wire.connect(self.radio.address[kind])
        wire.setsockopt(*_NODELAY)
        wire.setblocking(False)
        return wire

    def run_ms(self, milliseconds):
        end = self.port.now + int(milliseconds * TICKS_PER_MS)
        while self.port.now < end:
            self.app.cycle()
            for browser in self.browsers:
                browser.look()

    def page(self, key=KEY):
        return Browser(self, key)

    def get(self, path, method="GET", host=b"127.0.0.1", more=b"", body=b""):
        """The whole answer to a request."""
        wire = self.connect()
        wire.send(b"%s %s HTTP/1.1\r\nHost: %s\r\n" % (method.encode(), path.encode(), host) + more + b"\r\n" + body)
        data = b""
        for _ in range(_ANSWERED_MS):
            self.run_ms(1)
            came = receive(wire)
            if came == b"":
                break
            data += came or b""
        wire.close()
        return data

    def sender(self):
        return Sender(self)

    def commanding(self):
        """A page that has the command of a router that is unlocked."""
        page = self.page()
        page.until(lambda state: state["link"])
        assert page.order("give", to="page")["error"] == 0
        page.until(lambda state: state["owner"] == "page")
        assert page.order("unlock")["error"] == 0
        page.until(lambda state: state["state"] == "Idle")
        return page


def receive(wire):
    """Return the bytes received; None: none yet; b"": the other end has gone."""
    try:
        return wire.recv(4096)
    except OSError as error:
        return None if error.errno in AGAIN else b""


def masked(kind, data):
    """A frame as a browser sends it."""
    size = len(data)
    head = bytes((0x80 | kind, 0x80 | size)) if size < 126 else bytes((0x80 | kind, 0x80 | 126, size >> 8, size & 0xFF))
    return head + _MASK + bytes([data[at] ^ _MASK[at & 3] for at in range(size)])


class Browser:
    """One page: the work of its script, without a screen."""

    PATH = b"/ws"
    ORIGIN = b"Origin: http://127.0.0.1\r\n"

    def __init__(self, board, key):
        self._board = board
        self.wire = board.connect()
        self._data = b""
        self.head = None
        self.alive = True
        self.reading = True
        self.ponging = True
        self.told = []
        self.state = {}
        self.pushes = []  # (ms, state)
        self.count = self.asked = 0
        board.browsers.append(self)
        self.send(
            b"GET " + self.PATH + b" HTTP/1.1\r\nHost: 127.0.0.1\r\n" + self.ORIGIN + b"Upgrade: websocket\r\nConnection: Upgrade\r\n"
            b"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
        )
        self.hello = self.wait(lambda message: message["t"] == "hello") if key else None
        self.session = Session(key, self.hello["nonce"]) if self.hello else None

    def send(self, data):
        self.wire.send(data)

    def close(self):
        self.wire.close()
        self._board.browsers.remove(self)

    def say(self, text):
        self.send(masked(1, text.encode()))

    def look(self):
        if not self.reading or not self.alive:
            return
        came = receive(self.wire)
        if came == b"":
            self.alive = False
        self._data += came or b""
        if self.head is None:
            end = self._data.find(b"\r\n\r\n")
            if end < 0:
                return
            self.head = self._data[:end]
            self._data = self._data[end + 4 :]
        while len(self._data) > 1:
            start = 2 if self._data[1] < 126 else 4
            size = self._data[1] if start == 2 else self._data[2] << 8 | self._data[3]
            if len(self._data) < start + size:
                return
            kind = self._data[0] & 15
            data = self._data[start : start + size]
            self._data = self._data[start + size :]
            if kind == 9 and self.ponging:
                self.send(masked(10, data))
            elif kind == 1:
                self._hear(data.decode())

    def _hear(self, text):
        message = json.loads(text)
        if message["t"] == "state":
            self.state = message
            self.pushes.append((self._board.now_ms(), message))
        else:
            self.told.append(message)

    def wait(self, wanted):
        """A message that is as wanted, which is taken; None: none came."""
        for _ in range(_ANSWERED_MS):
            for message in self.told:
                if wanted(message):
                    self.told.remove(message)
                    return message
            self._board.run_ms(1)
        return None

    def message(self, order):
        """An order with its proof."""
        self.count += 1
        body = json.dumps(order)
        return "%d.%s.%s" % (self.count, self.session.proof(str(self.count), body), body)

    def order(self, do, proven=True, **fields):
        """The answer to an order."""
        self.asked += 1
        number = fields["id"] = self.asked
        self.begin(do, proven, **fields)
        return self.wait(lambda message: message.get("id") == number)

    def begin(self, do, proven=True, **fields):
        fields["do"] = do
        self.say(self.message(fields) if proven else json.dumps(fields))

    def until(self, wanted):
        for _ in range(10 * _ANSWERED_MS):
            if self.state and wanted(self.state):
                return self.state
            self._board.run_ms(1)
        raise AssertionError("not so: %r" % self.state)


class Sender(Browser):
    """A sender of G-code, which proves its lines."""

    PATH = b"/grbl"
    ORIGIN = b""

    def __init__(self, board):
        self._heard = ""
        Browser.__init__(self, board, None)

    def _hear(self, text):
        self._heard += text
        if self._heard[:7] == "[PASSO:" and self.session is None:
            self.session = Session(KEY, self._heard[7 : self._heard.find("]")])

    def said(self):
        """Return the text received since the last call, 20 ms later."""
        self._board.run_ms(20)
        heard = self._heard
        self._heard = ""
        return heard.encode()

    def put(self, data):
        self.send(masked(1, data))

    def line(self, body, cut=1000):
        """A proven line, in pieces of `cut` bytes."""
        self.count += 1
        text = body.decode()
        data = ("%d.%s.%s\n" % (self.count, self.session.proof(str(self.count), text), text)).encode()
        for at in range(0, len(data), cut):
            self.put(data[at : at + cut])
