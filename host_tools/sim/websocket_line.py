"""A WebSocket on this PC for a sender that speaks plain grbl by one, such as UGS: beside PtyLine and TcpLine, with the same methods.

    line = WebSocketLine(8081)          # line.name: ws://127.0.0.1:8081/
    line.read(), line.write(data)

A page of another site is refused by its Origin, and one client at a time is served: a new one takes the place of the old.
"""

import socket
import time

from host_tools.failure import Failure, reason
from passo.records import COUNT_MASK
from passo.web.guard import Guard
from passo.web.http import Server
from passo.web.websocket import TEXT, frame

_HOST = "127.0.0.1"
_PIECE = 1000  # bytes of a message


class _Nothing:
    """The files of a server that has none."""

    def find_file(self, path):
        return None


def _now_ms():
    return int(time.monotonic() * 1000) & COUNT_MASK


class WebSocketLine:
    browser = False  # most senders name no Origin

    def __init__(self, port):
        """`port`: 0: any. Raises Failure if it cannot be had."""
        try:
            listener = socket.create_server((_HOST, port))
        except (OSError, OverflowError) as error:
            raise Failure("cannot serve a WebSocket on port {}: {}", port, reason(error)) from error
        self._server = Server(listener, _Nothing(), Guard((_HOST.encode(), b"localhost"), None, "", lambda peer: False), _now_ms, False)
        self._server.sockets[b"/"] = self
        self._connection = None
        self.clients = 0  # connections so far
        self._come = b""
        self.name = f"ws://{_HOST}:{listener.getsockname()[1]}/"

    def read(self):
        self._server.poll(_now_ms())
        come, self._come = self._come, b""
        return come

    def write(self, data):
        """Lost while there is no client."""
        data = bytes(data)
        for at in range(0, len(data), _PIECE):
            if self._connection:
                self._server.send(self._connection, frame(TEXT, data[at : at + _PIECE]))

    def select_list(self):
        return self._server.select_list()

    def close(self):
        self._server.close()

    # --- for the server

    def open(self, connection, now_ms):
        """Take a new connection, and drop the one before with a message. Returns b"": no bytes to send."""
        if self._connection:
            self._server.send(self._connection, frame(TEXT, b"[MSG:Another program has taken this connection]\r\n"))
            self._server.drop(self._connection)
        self._connection = connection
        self.clients += 1
        return b""

    def take_message(self, connection, data, now_ms):
        self._come += data
        return connection is self._connection

    def forget_connection(self, connection):
        if connection is self._connection:
            self._connection = None
