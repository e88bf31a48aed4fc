"""A servo as pen lift: it follows the tool, as played, at speeds of its own.

    "servo": {"pin": 11, "up_us": 1000, "down_us": 1600, "up_ms": 100, "down_ms": 250}

A pulse every 20 ms says where the arm should be. It changes in proportion to the time, from up_us to down_us in down_ms, and
back in up_ms: a pen that is set down slowly does not bounce. tool.on_ms and tool.off_ms have the machine wait meanwhile.
With by_s the arm goes down by S of $30: a pressure for each line.

The main loop moves it, once a pulse; an alarm lifts the pen.
"""

from micropython import const

from passo.control.feature import Feature
from passo.records import COUNT_MASK

_PULSE_MS = const(20)
_DOWN = const(1000)


class PenServo(Feature):
    def __init__(self, board, machine, queue):
        Feature.__init__(self, board, machine, queue)
        self._config = config = board["servo"]
        self._height = 0  # 0: up … 1000: down
        self._moved_ms = machine.port.machine_ms()
        self._pulse = machine.port.make("servo", (config["pin"], 1000 * config["up_us"]))

    def look(self, now_ms):
        """Move the arm on, once a pulse, in proportion to the time that has passed."""
        passed_ms = (now_ms - self._moved_ms) & COUNT_MASK
        if passed_ms < _PULSE_MS:
            return
        self._moved_ms = now_ms
        config, queue, height = self._config, self._queue, self._height
        wanted = 0
        if queue.lit() and not self._machine.alarm:
            wanted = queue.analogue.level if config["by_s"] else _DOWN
        if wanted == height:
            return
        way = min(passed_ms, 2 * _PULSE_MS) * _DOWN  # behind a longer cycle it takes up where it was
        if wanted > height:
            height = min(wanted, height + way // max(config["down_ms"], 1))
        else:
            height = max(wanted, height - way // max(config["up_ms"], 1))
        self._height = height
        self._pulse.duty_ns(1000 * config["up_us"] + (config["down_us"] - config["up_us"]) * height)
