"""The shop's knowledge of machines. Any client of the broker may name one; a machine that has proven the shop's key always has room.

    machines = Machines(key, nonce)
    machines.note_topic(name, "state", "idle")     # the text before; None: there was none, or there is no room for another stranger
    machines.open(name, text)               # what a machine tells, signed, a dict; None: not signed for this nonce, or told before
    machines.stale                          # True: one was signed right, but is older than the last
    machines.renew(nonce)
    machines.known                          # {name: {"state": …, "how": …}}
"""

import re

from host_tools.shop.signed import MACHINE, Opener

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,39}")
MOST_STRANGERS = 300  # names that have not proven the key: machines of agents without it, too
_MOST_LETTERS = 2000  # of a text


class Machines:
    def __init__(self, key, nonce):
        self._key = key
        self._nonce = nonce
        self._openers = {}  # name: of those that have proven the key
        self.known = {}
        self.stale = False
        self.missed = False  # something of a machine has been dropped for strangers, before it proved the key

    def renew(self, nonce):
        """Accept only messages signed for another nonce from now on, numbered anew."""
        self._nonce = nonce
        self._openers = dict.fromkeys(self._openers)
        self.stale = False

    def note_topic(self, name, topic, text):
        """Note a machine's topic. Returns the text before; None: there was none, or there is no room for another stranger."""
        if len(text) > _MOST_LETTERS or name not in self.known and not self._has_room(name):
            return None
        told = self.known.setdefault(name, {})
        before, told[topic] = told.get(topic), text
        return before

    def _has_room(self, name):
        """True if another name may be known: MOST_STRANGERS at most without the key."""
        return bool(NAME.fullmatch(name)) and len(self.known) - len(self._openers) < MOST_STRANGERS

    def open(self, name, text):
        """Return the dict of a machine's signed message; None: it is not signed for this nonce, or is no newer than the last."""
        if not NAME.fullmatch(name):
            return None
        opener = self._openers.get(name) or Opener(self._key, MACHINE, f"{self._nonce} {name}")
        told = opener.open(text)
        if told is None:
            self.stale = self.stale or opener.is_older(text)
            return None
        if name not in self._openers and name not in self.known:
            self.missed = True
            self.known[name] = {}
        self._openers[name] = opener
        return told
