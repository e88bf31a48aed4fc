"""A sensor whose edge is caught in its interrupt: only boards whose `homing` has `latch` load it."""

from passo.control.sensor import Sensor


class LatchedSensor(Sensor):
    def __init__(self, read, debounce_ms, latch, axis):
        self._latch = latch
        self._axis = axis
        Sensor.__init__(self, read, debounce_ms)

    def restart(self, now_ms):
        Sensor.restart(self, now_ms)
        self._latch.arm()

    def sample(self, now_ms, position):
        latch = self._latch
        if latch.caught and not self.active and not self.pending:  # it may be over by now
            self.pending = True
            self.edge = latch.position[self._axis]
            self._against_ms = self._calm_ms = 0
        pending, active = self.pending, self.active
        Sensor.sample(self, now_ms, position)
        if pending and not self.pending and not self.active or active and not self.active:
            latch.arm()  # it was noise, or the sensor is free again
