"""The part of Python's `random` that the plant uses, for a tab: MicroPython has no generator of one's own."""


class Random:
    """Linear congruences modulo 2³¹ (Lewis, Goodman and Miller, 1969)."""

    def __init__(self, seed=0):
        self._state = int(seed * 1_000_000) % 2147483646 + 1

    def random(self):
        """Return a number from 0 to 1."""
        self._state = self._state * 16807 % 2147483647
        return self._state / 2147483647

    def randint(self, low, high):
        """Return an integer from `low` to `high`, both included."""
        return low + int(self.random() * (high - low + 1))
