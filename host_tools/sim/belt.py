"""One belt and two motors that move both carriages of a plant (CoreXY).

    belt = Belt(plant)
    moved = belt.turn_motor(tick, motor, steps)

Its own reckoning, not the firmware's: x = (a + b) / 2, y = (a − b) / 2. A motor whose carriage stands at a hard end stalls.
"""


class Belt:
    motors = range(2)  # that it belongs to

    def __init__(self, plant):
        self._plant = plant
        x, y = plant.position[:2]
        self._turned = [x + y, x - y]

    def turn_motor(self, tick, motor, steps):
        """Turn a motor by steps. Returns True if a carriage has moved a whole step."""
        plant = self._plant
        motors = list(self._turned)
        motors[motor] += steps
        places = (motors[0] + motors[1]) // 2, (motors[0] - motors[1]) // 2
        moved = False
        for axis, place in enumerate(places):
            if place != plant.position[axis]:
                if not plant.move_axis(tick, axis, place - plant.position[axis]):
                    return moved
                moved = True
        self._turned = motors
        return moved
