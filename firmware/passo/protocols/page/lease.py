"""A jog that lasts as long as somebody holds it: a lease, to be renewed within 200 ms, and never revived.

    lease = Lease()
    lease.begin(7, beat, now_ms)    # a number higher than any before
    lease.renew(7, beat, now_ms)    # False: it has ended, whatever comes late
    lease.is_alive(now_ms)

`beat` is the number of the newest report that the holder has seen. A message whose sender has seen only reports older than FRESH_MS was
held up on its way, and counts for nothing: a burst that a network lets go late moves nothing.
"""

from micropython import const

from passo.records import COUNT_MASK

LEASE_MS = const(200)
FRESH_MS = const(500)
_BEATS = const(16)  # times of beats that are kept
_HALF = const(0x10000000)


def ms_since(now_ms, then_ms):
    """Milliseconds from then to now, of a clock modulo 2²⁹."""
    return (now_ms - then_ms) & COUNT_MASK


class Lease:
    def __init__(self):
        self.number = 0  # of the newest that began
        self._until_ms = 0
        self._held = False
        self._beats = [(0, 0)]  # (number, ms), the newest last

    def note_beat(self, number, now_ms):
        """Note that report `number` was sent at `now_ms`; the last _BEATS are kept."""
        self._beats.append((number, now_ms))
        if len(self._beats) > _BEATS:
            self._beats.pop(0)

    def is_fresh(self, number, now_ms):
        """True if report `number` was sent within FRESH_MS."""
        for beat, ms in self._beats:
            if beat == number:
                return ms_since(now_ms, ms) <= FRESH_MS
        return False

    def begin(self, number, beat, now_ms):
        """Begin lease `number` and return True, if it is higher than any before, no lease is under way and the holder's `beat` is fresh."""
        if self.is_alive(now_ms) or number <= self.number:
            return False
        self.number = number  # used up, whatever comes of it
        if not self.is_fresh(beat, now_ms):
            return False
        self._held = True
        self._until_ms = (now_ms + LEASE_MS) & COUNT_MASK
        return True

    def renew(self, number, beat, now_ms):
        """Let lease `number` last LEASE_MS from now and return True, if it is alive and the holder's `beat` is fresh."""
        if number != self.number or not self.is_alive(now_ms) or not self.is_fresh(beat, now_ms):
            return False
        self._until_ms = (now_ms + LEASE_MS) & COUNT_MASK
        return True

    def end(self):
        self._held = False

    def is_alive(self, now_ms):
        """Return whether the lease lasts. Once it has lapsed, it has ended for good."""
        if self._held and ms_since(self._until_ms, now_ms) >= _HALF:
            self._held = False
        return self._held
