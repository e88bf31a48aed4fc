"""TMC2209 drivers, some of which feel where their axis ends: while the machine homes they have less current, stealthChop and a threshold.

All are set up anew, and read back, as homing begins and as it ends, however it does; nothing moves in between. A driver compares
SG_RESULT, which falls with the load, with twice the threshold, and says on its DIAG pin that it is below. Before it has a threshold the pin
is silent: one that is not, of a short or a driver in trouble, is alarm 8 before anything moves. So with drivers on SPI: spi_drivers/control_stall.py.
"""

from micropython import const

from passo import commands, errors
from passo.control.feature import ANEW, HOMING
from passo.options.drivers import config as chip
from passo.options.drivers import control as drives

TCOOLTHRS = const(0x14)  # clocks a microstep from which on DIAG tells
SLOWEST = const(0xFFFFF)
_SGTHRS = const(0x40)


class Motors(drives.Motors):
    event_mask = HOMING
    _stealth = True  # the chopper in which they feel

    def __init__(self, board, machine, queue):
        self._config = board["additions"].drives
        self._sensors = board["homing"]["sensors"]
        self._stalls = board["additions"].stalls
        self._set = 0
        self._asked = self._feels = False  # whether they are to feel, and whether they have got that order
        drives.Motors.__init__(self, board, machine, queue)

    def on_events(self, what):
        """Have the drivers feel from here on: homing begins."""
        self._asked = True

    def ready(self):
        """Return whether all drivers are set up, for feeling or not, as homing wants."""
        return self._asked == self._feels and drives.Motors.ready(self)

    def look(self, now_ms):
        """Set the drivers up anew as homing begins, and as it ends; see the base."""
        if self._asked and not self._machine.busy_with(commands.HOME):
            self._asked = False
        if self._asked != self._feels and self._register < 0:
            self._feels = self._asked
            if not self._feels or not self._check_stuck():
                self._begin_set_up()
        drives.Motors.look(self, now_ms)

    def _check_stuck(self):
        """Return True, and raise an alarm, if the DIAG pin of a driver that has no threshold yet is active."""
        machine = self._machine
        for axis in self._stalls:
            if machine.inputs.read(self._sensors[axis]):
                self._asked = self._feels = False
                machine.raise_alarm(errors.ALARM_SENSOR_STUCK, "driver of %s: DIAG is active" % axis, ANEW)
                machine.announce_restart()
                return True
        return False

    def _begin_set_up(self):
        """Compute the registers, with the current and threshold for feeling or without, and begin to set all up."""
        # Drivers that are set up are not told to forget a failure of their power: it may have come this moment.
        self._kept = self._set == len(self._motors)
        self._registers = []
        for motor in self._motors:
            feels = self._feels and motor["axis"] in self._stalls
            if feels:
                motor = dict(motor)
                motor["current_ma"] = motor["stall_ma"] or motor["current_ma"]
                motor["stealth"] = self._stealth
            self._registers.append([row for row in self._register_rows(motor, feels) if not self._kept or row[0] != chip.GSTAT])
        drives.Motors._begin_set_up(self)

    def _register_rows(self, motor, feels):
        """Return the rows of chip.register_rows() and those for feeling; the two that can be read back stay the last."""
        rows = chip.register_rows(motor, self._config["sense_mohm"])
        return rows[:-2] + ((_SGTHRS, motor["stall"] if feels else 0), (TCOOLTHRS, SLOWEST if feels else 0)) + rows[-2:]
