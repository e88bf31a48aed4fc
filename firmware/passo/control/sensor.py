"""One switch or optical barrier, filtered: it neither trips on noise nor loses the position where it first moved."""


class Sensor:
    """`active` follows the input once the readings against it outweigh those for it by `debounce_ms`. `edge` is the
    position where the change that was then believed first showed, chatter included; a change that has not shown again
    for `debounce_ms` was noise, and is forgotten. Noise denser than that needs a longer `debounce_ms`. With `latch`, a Latch of
    the pin (homing), `edge` is exact to the step; without, it is the position at the cycle that noticed the change."""

    _latch = None

    def __init__(self, read, debounce_ms, latch=None, queue=None, axis=0):
        self._read = read
        if latch:
            self._latch = latch
            self._kept = queue, axis
        self.debounce_ms = debounce_ms
        self.edge = 0
        self.restart(0)

    def restart(self, now_ms, active=None):
        """Take `active`, default the input's present level, as the state, and forget any change under way."""
        self.active = self._read() if active is None else active
        self.pending = False  # a change has shown and is not yet believed
        self._against_ms = self._calm_ms = 0
        self.last_ms = now_ms
        if self._latch:
            self._latch.begin(*self._kept[0].lend())

    def sample(self, now_ms, position):
        """Read the input once; `position`: of the axis, in steps. Call it at least once a step and once a millisecond."""
        passed_ms = (now_ms - self.last_ms) & 0x1FFFFFFF
        self.last_ms = now_ms
        pending = self.pending
        same = self._read() == self.active
        if not pending and not self.active and self._latch and self._latch.seen:  # asked after the reading: the interrupt has seen every edge that the reading shows
            queue, axis = self._kept
            position = queue.axis(axis, self._latch)
            if same:  # it is over by now
                self.pending = True
                self.edge = position
                self._against_ms = self._calm_ms = passed_ms = 0
        if same:
            self._against_ms = max(0, self._against_ms - passed_ms)
            self._calm_ms += passed_ms
            self.pending = self.pending and self._calm_ms < self.debounce_ms
            if pending and not self.pending:
                self.restart(now_ms, self.active)  # it was noise
            return
        if not self.pending:
            self.pending = True
            self.edge = position
            self._against_ms = passed_ms = 0  # when it began since the last reading nobody knows
        self._calm_ms = 0
        self._against_ms += passed_ms
        if self._against_ms >= self.debounce_ms:
            self.restart(now_ms, not self.active)
