"""How often a page gets the state: as it asks, or only after changes.

    pace = Pace()
    answer = pace.look({"do": "look", "every": 500})        # milliseconds; 0: only when more changes than positions
    pace.is_due(version, now_ms)

A jog wants reports that are fresh (lease.py): a page that has them rarely asks for more of them before it moves the machine.
"""

from micropython import const

from passo import errors
from passo.protocols.page.lease import ms_since

_MOST_MS = const(10_000)
_EARLY_MS = const(5)  # a report this near to its time goes now, not a push later


class Pace:
    def __init__(self):
        self._every_ms = 1
        self._told_ms = 0
        self._told = None

    def look(self, order):
        """Set how often the page gets the state, by an order's `every` in ms, 0 … 10,000; returns its answer. It needs no key."""
        every = order.get("every")
        good = isinstance(every, int) and not isinstance(every, bool) and 0 <= every <= _MOST_MS
        if good:
            self._every_ms = every
            self._told = None  # the next report comes at once
        return {"t": "answer", "do": "look", "error": 0 if good else errors.ORDER_FIELD}

    def is_due(self, version, now_ms):
        """Return whether the page gets the state now: if its time has come, or at once if `version` is another one."""
        if version == self._told and (not self._every_ms or ms_since(now_ms, self._told_ms) + _EARLY_MS < self._every_ms):
            return False
        self._told = version
        self._told_ms = now_ms
        return True
