"""A link whose bytes come over the network: to the app it is a serial line.

    line = make(board, link, radio, clock_ms)
    line.join(controller, protocol)         # of HTTP, once both are there
    line.read(), line.write(data), line.any()

`radio` says where to listen and who belongs to the board's own network: radio.py, or the virtual board's. Without one, or while
the board has no Wi-Fi data, the line is silent.
"""

from passo.web.guard import Guard, nonce
from passo.web.http import Server
from passo.web.radio import Radio  # noqa: F401: for who makes lines
from passo.web.signed import SignedLine

_PAGE = __file__[: __file__.rfind("/")] + "/page/" if "/" in __file__ else "page/"
FILES = {
    b"/torch.js": (b"text/javascript; charset=utf-8", _PAGE + "torch.js"),
    b"/torch.css": (b"text/css; charset=utf-8", _PAGE + "torch.css"),
    b"/sha256.js": (b"text/javascript; charset=utf-8", _PAGE + "sha256.js"),
}


def make(board, link, radio, clock_ms):
    """The line of a link. `board` and `link`: of the board file; `clock_ms()`: the links' clock."""
    listener = radio.listen(link["port"]) if radio else None
    if listener is None:
        return Silent()
    if link["port"] == "tcp":
        return SignedLine(listener, radio.key)
    return HttpLine(listener, radio, board["network"]["legacy_http"], clock_ms)


class Silent:
    """The radio is off."""

    def any(self):
        return False

    def read(self):
        return b""

    def write(self, data):
        pass

    def watched(self):
        return []

    def close(self):
        pass


class HttpLine:
    def __init__(self, listener, radio, legacy, clock_ms):
        """`listener`: a socket that listens; `legacy`: who has no key may be admitted."""
        self._clock_ms = clock_ms
        self._legacy = legacy
        self._guard = Guard(radio.names, radio.key, nonce(), radio.own)
        self._server = Server(listener, FILES, self._guard)

    def join(self, controller, protocol):
        """What the server is to know of the machine and its language."""
        admission = controller.features["admission"]
        self._guard.admit(admission.admitted if self._legacy else None, protocol.FREE)
        self._server.serve(protocol.POSTS, protocol.GETS, _PAGE + protocol.PAGE)

    def any(self):
        return self._server.waiting()

    def read(self):
        """The next request, or b""."""
        self._server.poll(self._clock_ms())
        return self._server.take()

    def write(self, data):
        self._server.answer(data)

    def watched(self):
        return self._server.watched()

    def close(self):
        self._server.close()
