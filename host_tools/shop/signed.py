"""Messages between a shop and its machines, signed as the orders of a page are (passo/web/session.py): by a key that both know and nobody sends.

    text = sign_message(key, SHOP, nonce, 1, {"job": …})
    Opener(key, SHOP, nonce).open(text)     # the dict; None: without the key, altered, or received before

The receiver chooses the nonce. Messages of machines and orders of a shop are signed for different ends, so neither passes for the other.
"""

import json

from passo.web.session import Session

MACHINE = "machine"  # a machine tells the shop; the nonce is the shop's, with the machine's name
SHOP = "shop"  # the shop orders; the nonce is the machine's


def _make_session(key, end, nonce):
    """The session that signs and checks messages for one end, under a nonce."""
    return Session(key, f"{end} {nonce}")


def sign_message(key, end, nonce, count, body):
    """Sign a dict: the text `COUNT.PROOF.JSON` for `end`, under its nonce."""
    text = json.dumps(body, ensure_ascii=False)
    return f"{count}.{_make_session(key, end, nonce).proof(str(count), text)}.{text}"


class Opener:
    def __init__(self, key, end, nonce):
        self._about = key, end, nonce
        self._session = _make_session(key, end, nonce)

    def is_older(self, text):
        """True if a message is signed right, and counted lower than the last: it is repeated, or the clock of its PC has been set back."""
        fresh = _make_session(*self._about)
        return fresh.open(text) is not None and fresh.count < self._session.count

    def open(self, text):
        """Return the dict of a signed message; None: the proof is wrong, the count is not higher than the last, or it is no JSON object."""
        body = self._session.open(text)
        if body is None:
            return None
        try:
            found = json.loads(body)
        except ValueError:
            return None
        return found if isinstance(found, dict) else None
