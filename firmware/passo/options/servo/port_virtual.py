"""The PWM of a pen's servo on the virtual port."""


class Servo:
    def __init__(self, port, ns):
        self._port = port
        self.duty_ns(ns)

    def duty_ns(self, ns):
        """Give the world the length of the pulse."""
        self._port.world.servo(self._port.now, ns // 1000)


def create(port, config):
    """Return the Servo."""
    return Servo(port, config[1])
