"""Samples where the processor of an emulated Pico spends its time.

    load = Load(pico)           # from now on, a sample every 10 µs
    pico.run(100_000)
    load.end()                  # {"timers": 0.31, "main": 0.42, "asleep": 0.25, …}
"""

SAMPLE_NS = 10_008  # whole cycles; not in step with anything measured
_EXCEPTIONS = {0: "main", 16 + 3: "timers", 16 + 5: "usb", 16 + 13: "pins", 16 + 7: "pio", 16 + 20: "uart"}


class Load:
    """"timers" is the interrupt that feeds, "main" the main loop with its garbage collections."""

    def __init__(self, pico):
        self._core = pico.chip.core
        self._counts = {}
        self._alarm = pico.chip.clock.create_alarm(self._take_sample)
        self._alarm.schedule(SAMPLE_NS)

    def _take_sample(self):
        name = "asleep" if self._core.waiting else _EXCEPTIONS.get(self._core.ipsr, "other interrupts")
        self._counts[name] = self._counts.get(name, 0) + 1
        self._alarm.schedule(SAMPLE_NS)

    def end(self):
        """Stop sampling; return {name: share of all samples}."""
        self._alarm.cancel()
        total = sum(self._counts.values()) or 1
        return {name: count / total for name, count in self._counts.items()}
