"""The pulses of an input on the virtual port: its world counts them."""

from passo.records import COUNT_MASK


class Pulses:
    def __init__(self, port):
        self._port = port
        self.us = 0

    def count_pulses(self):
        """See PinPulses; the world counts."""
        count, tick = self._port.world.pulses(self._port.now)
        self.us = tick * 2 // 25 & COUNT_MASK
        return count & COUNT_MASK


def create(port, name):
    """Return the Pulses."""
    return Pulses(port)
