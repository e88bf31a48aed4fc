"""One switch or optical barrier, filtered: it neither trips on noise nor loses the place where it first moved."""


class Sensor:
    """`active` follows the input once the readings against it outweigh those for it by `debounce_ms`. `edge` is the
    place where the change that was then believed first showed, chatter included; a change that has not shown again
    for `debounce_ms` was noise, and is forgotten. Noise denser than that needs a longer `debounce_ms`."""

    def __init__(self, read, debounce_ms, latch=None, axis=0):
        """`latch`: catches the place of `axis` as the change comes, else it is where it stands when sample() sees it."""
        self._read = read
        self._latch = latch
        self._axis = axis
        self.debounce_ms = debounce_ms
        self.edge = 0
        self.restart(0)

    def restart(self, now_ms):
        """Believe the input as it is now."""
        self.active = self._read()
        self.pending = False  # a change has shown and is not yet believed
        self._against_ms = self._calm_ms = 0
        self._last_ms = now_ms
        self._arm()

    def _arm(self):
        if self._latch is not None:
            self._latch.arm()

    def pass_by(self, now_ms):
        """Nothing has changed until now."""
        self._last_ms = now_ms

    def sample(self, now_ms, place):
        """Look once; `place` is where the axis stands. Call it at least once a step and once a millisecond."""
        passed_ms = (now_ms - self._last_ms) & 0x1FFFFFFF
        self._last_ms = now_ms
        latch = self._latch
        if latch is not None and latch.caught and not self.active and not self.pending:  # it may be over by now
            self.pending = True
            self.edge = latch.place[self._axis]
            self._against_ms = self._calm_ms = 0
        if self._read() == self.active:
            self._against_ms = max(0, self._against_ms - passed_ms)
            self._calm_ms += passed_ms
            if self.pending and self._calm_ms >= self.debounce_ms:
                self.pending = False
                self._arm()
            return
        if not self.pending:
            self.pending = True
            self.edge = place
            self._against_ms = 0
        self._calm_ms = 0
        self._against_ms += passed_ms
        if self._against_ms >= self.debounce_ms:
            self.active = not self.active
            if not self.active:
                self._arm()
            self.pending = False
            self._against_ms = 0
