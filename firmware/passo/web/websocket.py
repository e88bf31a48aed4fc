"""WebSockets as a server has them (RFC 6455): the browser's bytes are masked, the server's are not.

    accept_of(key)                      # the answer to the head's Sec-WebSocket-Key
    frames = Frames(1024)
    for kind, data in frames.feed(b"…"):    # raises ValueError: it is to be closed
    frame(TEXT, b"…")                   # bytes to send

A message is one frame: browsers send none in pieces that are as short as orders are.
"""

import hashlib
from binascii import b2a_base64

from micropython import const

TEXT = const(1)
BINARY = const(2)
CLOSE = const(8)
PING = const(9)
PONG = const(10)
_END = const(0x80)  # of the first byte: the message's last frame
_MASKED = const(0x80)  # of the second
_SHORT = const(126)  # lengths below it stand in the second byte
_CONTROL_MOST = const(125)
_KINDS = (TEXT, BINARY, CLOSE, PING, PONG)
_ID = b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11"


def accept_of(key):
    """Sec-WebSocket-Accept for a Sec-WebSocket-Key, bytes (RFC 6455, section 4.2.2)."""
    return b2a_base64(hashlib.sha1(key + _ID).digest()).strip()


def frame(kind, data):
    """A server's frame with `data`, bytes, 65535 at most (RFC 6455, section 5.2). `kind`: TEXT, PING …"""
    size = len(data)
    if size < _SHORT:
        return bytes((_END | kind, size)) + data
    return bytes((_END | kind, _SHORT, size >> 8, size & 0xFF)) + data


class Frames:
    def __init__(self, most):
        """`most`: bytes of a message."""
        self._most = most
        self._data = b""

    def feed(self, data):
        """[(kind, bytes)] of the frames that `data` makes whole. Raises ValueError: not masked, too long, in pieces, unknown."""
        data = self._data + data
        found = []
        while len(data) > 1:
            kind = data[0] & ~_END
            size = data[1] & 0x7F
            start = 6
            if not data[0] & _END or kind not in _KINDS or not data[1] & _MASKED or size > (_CONTROL_MOST if kind >= CLOSE else _SHORT):
                raise ValueError("frame")
            if size == _SHORT:
                if len(data) < 4:
                    break
                size = data[2] << 8 | data[3]
                start = 8
            if size > self._most:
                raise ValueError("length")
            if len(data) < start + size:
                break
            # The mask is taken off in a few operations, whatever the length.
            masks = int.from_bytes((data[start - 4 : start] * (size // 4 + 1))[:size], "little")
            found.append((kind, (int.from_bytes(data[start : start + size], "little") ^ masks).to_bytes(size, "little")))
            data = data[start + size :]
        self._data = data
        return found
