"""The checks of each request, before the machine gets it.

    guard = Guard(names, key, nonce, own)
    guard.set_admission(admitted, free)
    guard.refusal_status(connection)    # the status that refuses it: a foreign Host or Origin, see is_own_request(); 0
    guard.is_proven(connection, now_ms)    # True if it may move the machine

A request proves that its sender has the key by the head's line `X-Passo: COUNT.PROOF`: PROOF is the HMAC-SHA256 of
`NONCE.COUNT.METHOD PATH BODY`, see session.py. Each answer tells the nonce, which is another after each start, and the last count.
A program of 2020 sends no proof: where the board file allows it, it is admitted from the board's own network, for as many minutes
as somebody at the machine has given.
"""

from binascii import hexlify
from os import urandom

from micropython import const

from passo.records import COUNT_MASK
from passo.web.session import Session

WRONG = const(5)  # wrong proofs, then none is looked at for
_PAUSE_MS = const(1000)
_NONCE_BYTES = const(16)


def is_own_request(host, origin, names, browser=False):
    """True if a request's Host is one of `names`, with a port or not, and its Origin is this server's page, or missing. Both are bytes in small
    letters, or None. `browser`: the Origin must not be missing, because a browser's WebSocket has one."""
    if host is None or (host if host[-1:] == b"]" else host.rsplit(b":", 1)[0]) not in names:
        return False
    return not browser if origin is None else origin == b"http://" + host


def make_nonce():
    """Make a nonce: 16 random bytes of the system in hex."""
    return hexlify(urandom(_NONCE_BYTES)).decode()


class Guard:
    def __init__(self, names, key, nonce, own):
        """`names`: host names and addresses, bytes in small letters, that are this board's; `key`: text, None: there is none; `nonce`:
        text, never the same twice; `own(peer)`: True if an address is of the board's own network."""
        self._names = names
        self._session = Session(key, nonce) if key else None
        self._own = own
        self._admitted = None
        self._free = self._keyed = ()
        self._count = 0  # of the last proof
        self._wrong = 0
        self._since_ms = 0

    def set_admission(self, admitted, free, keyed=()):
        """Set the rules for requests without a proof. `admitted()`: True while they are admitted; None: never. `free`: paths that want no proof;
        `keyed`: paths that always want one, because no program of 2020 knows them."""
        self._admitted = admitted
        self._free = free
        self._keyed = keyed

    def refusal_status(self, connection, browser=False):
        return 0 if is_own_request(connection.host, connection.origin, self._names, browser) else 403

    def is_free(self, path):
        return path in self._free

    def is_proven(self, connection, now_ms):
        """True if a request's proof is right, or it needs none. After WRONG wrong proofs none is checked for _PAUSE_MS."""
        if not connection.proof:
            return self._admitted is not None and connection.path not in self._keyed and self._own(connection.peer) and self._admitted()
        if self._session is None:
            return False
        if self._wrong >= WRONG:
            if (now_ms - self._since_ms) & COUNT_MASK < _PAUSE_MS:
                return False
            self._wrong = 0
        try:
            signed = connection.proof + b"." + connection.method + b" " + connection.path + b" " + connection.body
            if self._session.open(signed.decode()) is not None:
                self._count = int(connection.proof.partition(b".")[0])
                return True
        except ValueError:
            pass
        self._wrong += 1
        self._since_ms = now_ms
        return False

    def headers(self):
        """Return the lines of an answer's head: the nonce, and the last count."""
        if self._session is None:
            return b""
        return b"X-Passo-Nonce: %s\r\nX-Passo-Count: %d\r\n" % (self._session.nonce.encode(), self._count)
