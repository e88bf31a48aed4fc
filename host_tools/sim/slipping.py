"""Motors that feel: rotors that lag behind their field if something holds the carriage, and the DIAG pins of their drivers.

    plant = Plant(board, stalls=7)          # the seed of all that trembles
    plant.slipping.wire_drivers(drivers)            # a SimDrivers or SpiDrivers: threshold and the rest are in its registers
    plant.slipping.set_spike_share(0.02)              # the share of measurements at which a free motor seems to stall, until SG_RESULT is measured again

An axis homes where its hard end is, `pull_off_steps` from its origin. Against an end a rotor stands still while its field goes on; two full
steps behind it slips to the next pole, four full steps back. SG_RESULT falls in proportion to the lag, to 0 at one full step, and trembles
anew each time that the driver measures it, once a full step (TMC2209's datasheet, register 0x41; TMC5160's, 13.2; TMC2130's, 14.2). On a belt both motors hold both carriages.
"""

import random

from host_tools.sim.parts import pull_off_of

FREE = 200  # SG_RESULT of a motor without a load
TREMBLE = 30  # its standard deviation
LEAST = -1000  # one that is 0 with any SGT


class Slipping:
    def __init__(self, plant, board, seed):
        self._plant = plant
        self._random = random.Random(seed)
        self._often = 0.0
        self._drivers = None
        self._tick = 0  # of the last step
        self.slips = 0  # how often a rotor has lost four full steps
        names = [axis["name"] for axis in board["axes"]]
        homing = board["homing"]
        self.sensors = {}  # input, by the number of its motor
        self._full = [16] * len(names)
        for motor in board["additions"].drives["motors"]:
            number = names.index(motor["axis"])
            self._full[number] = motor["microsteps"]
            if motor["axis"] in board["additions"].stalls:
                self.sensors[number] = homing["sensors"][motor["axis"]]
                self._set_hard_stop(number, names[number] in homing.get("high_end", ""), pull_off_of(homing, names[number]))
        self._names = names
        self._belt = board.get("kinematics") == "corexy"
        self.motors = range(len(names))
        self._fields = self._motors_of(plant.position)  # position of each motor's field
        self._lost = [0] * len(names)  # its distance from the rotor without a load
        self._told = [None] * len(names)  # the part of a full step that SG_RESULT is of

    def _set_hard_stop(self, number, high, pull_off):
        """Put an axis's hard end `pull_off` steps beyond its origin, and the carriage inside it."""
        carriage = self._plant.carriages[number]
        if high:
            carriage.high = pull_off
        else:
            carriage.low = -pull_off
        carriage.position = self._plant.position[number] = min(max(carriage.position, carriage.low), carriage.high)

    def wire_drivers(self, drivers):
        """Connect the DIAG pins of `drivers` to this model's inputs."""
        self._drivers = drivers
        for number in self.sensors:
            driver = drivers[self._names[number]]
            driver.written = lambda motor=number, driver=driver: driver.can_feel_load or self._set_diag(self._tick, motor, False)

    def _set_diag(self, tick, motor, stalled):
        if motor in self.sensors:
            self._plant.set_input(tick, self.sensors[motor], stalled)

    def set_spike_share(self, often):
        """Have a share `often` (0…1) of the measurements show a stall on free motors."""
        self._often = often

    def _motors_of(self, places):
        """Turn axes' positions into motors' positions, in steps. On a belt (CoreXY) a second call turns them back, times two."""
        x, y = places[:2]
        return [x + y, x - y] + list(places[2:]) if self._belt else list(places)

    def turn_motor(self, tick, motor, steps):
        """Turn a motor's field by steps. Returns True if a carriage has moved."""
        self._tick = tick
        self._fields[motor] += steps
        moved = self._move_carriages(tick)
        lags = self._rotor_lags()
        for number in self.sensors:
            if abs(lags[number]) >= 2 * self._full[number]:
                self._lost[number] += 4 * self._full[number] * (1 if lags[number] > 0 else -1)
                self.slips += 1
                moved = self._move_carriages(tick) or moved
        if motor in self.sensors:
            self._measure_load(tick, motor, abs(self._rotor_lags()[motor]))
        return moved

    def _free_positions(self):
        """Return the positions of the carriages if nothing held them."""
        wanted = [field - lost for field, lost in zip(self._fields, self._lost)]
        if self._belt:
            wanted[:2] = (wanted[0] + wanted[1]) // 2, (wanted[0] - wanted[1]) // 2
        return wanted

    def _move_carriages(self, tick):
        """Move the carriages to the rotors' positions, held at the hard ends. Returns True if one has moved."""
        moved = False
        for axis, place in enumerate(self._free_positions()):
            carriage = self._plant.carriages[axis]
            if axis in self.sensors:
                place = min(max(place, carriage.low), carriage.high)
            if place != carriage.position:
                moved = self._plant.move_axis(tick, axis, place - carriage.position) or moved
        return moved

    def _rotor_lags(self):
        rotors = self._motors_of(self._plant.position)
        lags = [field - lost - rotor for field, lost, rotor in zip(self._fields, self._lost, rotors)]
        return [0 if self._belt and number < 2 and abs(lag) < 2 else lag for number, lag in enumerate(lags)]  # half a step of the belt

    def _measure_load(self, tick, motor, lag):
        """Measure SG_RESULT anew, once a full step: in proportion to the lag (microsteps), with tremble and spikes; set the DIAG pin."""
        full = self._full[motor]
        driver = self._drivers[self._names[motor]]
        part = self._fields[motor] // full
        if part == self._told[motor]:
            return
        self._told[motor] = part
        result = FREE * (1 - lag / full) + self._random.gauss(0, TREMBLE)
        if self._random.random() < self._often:
            result = LEAST
        self._set_diag(tick, motor, driver.diag_level(result))
