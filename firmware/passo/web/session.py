"""The signature of orders: a key that both sides know and neither sends.

    session = Session(key, nonce)           # a nonce for each connection, which the server sends first
    body = session.open(text)               # the order in `text`; None: it is not from someone who has the key

A message is `COUNTER.PROOF.BODY`; PROOF is the HMAC-SHA256 of `NONCE.COUNTER.BODY` in hex. Counters of a connection rise, so a
message heard on the wire is good for nothing: not again, and not on another connection.
"""

import hashlib
from binascii import hexlify

from micropython import const

_BLOCK = const(64)  # bytes of a block of SHA-256
_DIGITS = const(12)


class Hmac:
    """HMAC-SHA256 (RFC 2104) with a key, bytes."""

    def __init__(self, key):
        if len(key) > _BLOCK:
            key = hashlib.sha256(key).digest()
        key = key + bytes(_BLOCK - len(key))
        self._inner = bytes([byte ^ 0x36 for byte in key])
        self._outer = bytes([byte ^ 0x5C for byte in key])

    def hex_digest(self, message):
        """The HMAC of a message, bytes, as a text of 64 hex digits."""
        inner = hashlib.sha256(self._inner)
        inner.update(message)
        outer = hashlib.sha256(self._outer)
        outer.update(inner.digest())
        return hexlify(outer.digest()).decode()


def same_text(one, other):
    """True if two texts are equal; how long that takes says nothing of where they differ."""
    # As bytes: MicroPython keeps each letter taken out of a text as a name for good, and its table of names may grow by 1280 bytes.
    one, other = one.encode(), other.encode()
    if len(one) != len(other):
        return False
    differ = 0
    for at in range(len(one)):
        differ |= one[at] ^ other[at]
    return differ == 0


class Session:
    def __init__(self, key, nonce):
        """`key`: text (host_tools/clients/page_key.py makes it); `nonce`: text, never the same twice."""
        self._hmac = Hmac(key.encode())
        self.nonce = nonce
        self.opened = False  # a message has proven the key
        self.count = 0  # of the last message

    def open(self, text):
        """The body of a message, or None: a wrong proof, or a counter that is not higher than the last."""
        count, _, rest = text.partition(".")
        proof, _, body = rest.partition(".")
        if not count or len(count) > _DIGITS or [digit for digit in count.encode() if not 48 <= digit <= 57]:
            return None
        if not same_text(proof, self._hmac.hex_digest((self.nonce + "." + count + "." + body).encode())) or int(count) <= self.count:
            return None
        self.count = int(count)
        self.opened = True
        return body

    def proof(self, count, body):
        """The proof of a message, in hex; `count` as text."""
        return self._hmac.hex_digest((self.nonce + "." + count + "." + body).encode())
