"""The virtual board's radio: this PC's own loopback network in the place of Wi-Fi.

    radio = LoopbackRadio({"http": 8080}, key, board)
    radio.listen("http")            # a socket on 127.0.0.1; None: that port was not asked for

Connections from 127.0.0.x count as of the access point's own network, those from the rest of 127.0.0.0/8 do not, so that both can be tried on one PC.
"""

import socket
import tempfile
from pathlib import Path

from host_tools.build import pages
from host_tools.failure import Failure, reason

_HOST = "127.0.0.1"
_OWN = "127.0.0."
_BACKLOG = 64


class LoopbackRadio:
    names = (b"127.0.0.1", b"localhost", b"passo.local", b"192.168.4.1")  # the last: the board's address in the torch's program of 2020

    def __init__(self, ports, key, board):
        """`ports`: {"http": port, "tcp": port}, 0: any free one; `key`: text; `board`: whose files for browsers are served. Raises
        Failure if a port cannot be had."""
        self.key = key
        self._files = tempfile.TemporaryDirectory()  # lives as long as this
        self.folder = self._files.name + "/"
        pages.pack_files(board, Path(self.folder))
        self._sockets = {}
        for kind, port in ports.items():
            try:
                self._sockets[kind] = socket.create_server((_HOST, port), backlog=_BACKLOG)
            except (OSError, OverflowError) as error:
                raise Failure("cannot serve {} on port {}: {}", kind, port, reason(error)) from error

    def open_kinds(self):
        """Return the kinds of the open sockets: "http", "tcp"."""
        return list(self._sockets)

    def port_of(self, kind):
        return self._sockets[kind].getsockname()[1]

    def is_own_peer(self, peer):
        """True if an address is of the network of the board's own."""
        return peer.startswith(_OWN)

    def listen(self, kind):
        return self._sockets.get(kind)
