"""What a motor and its encoder may do to a machine: methods of the Plant, by the motor's name.

    plant.stall("x", 5)         # the next five steps of X are lost
    plant.slip("x2", -3)
    plant.lose_counts("y", 20)
"""


class Faults:
    def stall(self, motor, steps):
        """The next `steps` that a motor is asked for are lost."""
        self._carriage(motor).stall += steps

    def slip(self, motor, steps):
        """A motor turns by `steps` that nobody asked for."""
        carriage = self._carriage(motor)
        carriage.position += steps
        watching = [self._watching_second]
        if carriage in self.carriages:
            number = self.carriages.index(carriage)
            self.position[number] = carriage.position
            watching = [self._watching[number]] + self._others.get(number, [])
        for barrier in watching:
            if barrier is not None and (carriage.position <= barrier.last) != barrier.below:
                barrier.pass_by()

    def lose_counts(self, motor, counts):
        """An encoder misses so many counts forward."""
        self.encoders[motor].lost += counts

    def _carriage(self, motor):
        return next(carriage for carriage in self.carriages + [self.second] if carriage and carriage.name == motor)
