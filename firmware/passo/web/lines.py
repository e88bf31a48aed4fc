"""A link whose bytes come over the network: to the app it is a serial line.

    line = NetworkLine(board, link, radio, clock_ms)
    line.join(controller, protocol)         # once both are there
    line.read(), line.write(data), line.any()

`radio` says where to listen and who belongs to the board's own network: radio.py, or the virtual board's. Without one, or while
the board has no Wi-Fi data, the line is silent.
"""

from os import urandom

from passo.web.guard import Guard
from passo.web.http import Server
from passo.web.radio import Radio  # noqa: F401: for who makes lines
from passo.web.session import hex_of

_PAGE = __file__[: __file__.rfind("/")] + "/page/" if "/" in __file__ else "page/"
FILES = {
    b"/torch.js": (b"text/javascript; charset=utf-8", _PAGE + "torch.js"),
    b"/torch.css": (b"text/css; charset=utf-8", _PAGE + "torch.css"),
    b"/sha256.js": (b"text/javascript; charset=utf-8", _PAGE + "sha256.js"),
}
_NONCE_BYTES = 16


class NetworkLine:
    def __init__(self, board, link, radio, clock_ms):
        """`board` and `link`: of the board file; `clock_ms()`: the links' clock."""
        self._clock_ms = clock_ms
        self._server = None
        self._legacy = board["network"]["legacy_http"]
        listener = radio.listen(link["port"]) if radio else None
        if listener is not None:
            self._guard = Guard(radio.names, radio.key, hex_of(urandom(_NONCE_BYTES)), radio.own)
            self._server = Server(listener, FILES, self._guard)

    def join(self, controller, protocol):
        if self._server is None:
            return
        admission = controller.features["admission"]
        self._guard.admit(admission.admitted if self._legacy else None, protocol.FREE)
        self._server.serve(protocol.POSTS, protocol.GETS, _PAGE + protocol.PAGE)

    def any(self):
        return self._server is not None and self._server.waiting()

    def read(self):
        """The next request, or b""."""
        if self._server is None:
            return b""
        self._server.poll(self._clock_ms())
        return self._server.take()

    def write(self, data):
        if self._server is not None:
            self._server.answer(data)

    def watched(self):
        return self._server.watched() if self._server is not None else []

    def close(self):
        if self._server is not None:
            self._server.close()
