"""One switch or optical barrier, filtered: it neither trips on noise nor loses the position where it first moved."""


class Sensor:
    """`active` follows the input once the readings against it outweigh those for it by `debounce_ms`. `edge` is the
    position where the change that was then believed first showed, chatter included; a change that has not shown again
    for `debounce_ms` was noise, and is forgotten. Noise denser than that needs a longer `debounce_ms`."""

    def __init__(self, read, debounce_ms):
        self._read = read
        self.debounce_ms = debounce_ms
        self.edge = 0
        self.restart(0)

    def restart(self, now_ms):
        """Believe the input as it is now."""
        self.active = self._read()
        self.pending = False  # a change has shown and is not yet believed
        self._against_ms = self._calm_ms = 0
        self._last_ms = now_ms

    def pass_by(self, now_ms):
        """Nothing has changed until now."""
        self._last_ms = now_ms

    def sample(self, now_ms, position):
        """Look once; `position` is where the axis stands. Call it at least once a step and once a millisecond."""
        passed_ms = (now_ms - self._last_ms) & 0x1FFFFFFF
        self._last_ms = now_ms
        if self._read() == self.active:
            self._against_ms = max(0, self._against_ms - passed_ms)
            self._calm_ms += passed_ms
            self.pending = self.pending and self._calm_ms < self.debounce_ms
            return
        if not self.pending:
            self.pending = True
            self.edge = position
            self._against_ms = 0
        self._calm_ms = 0
        self._against_ms += passed_ms
        if self._against_ms >= self.debounce_ms:
            self.active = not self.active
            self.pending = False
            self._against_ms = 0
