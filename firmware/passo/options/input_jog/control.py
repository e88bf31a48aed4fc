"""A jog pendant: buttons, or a stick, on inputs of the board file.

    jog_x+  jog_x-  jog_y+ …        the axis moves while the input is active
    jog_fast                        beside them: as fast as the axes may

It moves at speed.default, or the axis's jog_steps_s. Two axes at once go along a diagonal. _AHEAD_MS of motion at most are queued at
any time, in pieces, so that it can stop within them; the button's release cancels them as grbl's 85h does. It keeps to the travel
of a machine that is homed. Only at a stand, or behind its own motion, and not with the tool on; a button that was held before
that counts once it has been released.
"""

from micropython import const

from passo.commands import JOG_CANCEL, JOG_TO, Motion
from passo.config import setting_numbers as table
from passo.control.feature import Feature
from passo.control.sensor import Sensor
from passo.errors import LATER
from passo.motion.integers import length_nm

_PIECE_MS = const(50)
_AHEAD_MS = const(250)  # twice of it is what braking from the highest speed may take


class Pendant(Feature):
    def __init__(self, board, machine, queue):
        Feature.__init__(self, board, machine, queue)
        self._axes = axes = board["axes"]
        self._slow = [axis["jog_steps_s"] or board["speed"]["default"] for axis in axes]
        letters = [axis["name"] for axis in axes]
        self._buttons = []  # (axis, +1 or −1, Sensor)
        self._fast = None
        for name in [item["name"] for item in board["inputs"] if item["name"][:4] == "jog_"]:
            if name == "jog_fast":
                self._fast = self._make_sensor(name)
            else:
                self._buttons.append((letters.index(name[4]), 1 if name[5] == "+" else -1, self._make_sensor(name)))
        self._wanted = [0] * len(axes)  # the directions at the last pass
        self._dead = False  # until all buttons have been released
        self._own = False  # the jog under way is this one's

    def _make_sensor(self, name):
        """Return a debounced Sensor of an input."""
        read = self._machine.inputs.read
        return Sensor(lambda: read(name), self._machine.settings.value(table.HOMING_DEBOUNCE))

    def look(self, now_ms):
        """Read the buttons; queue pieces of the jog, or cancel it as they change."""
        wanted = [0] * len(self._wanted)
        for axis, sign, sensor in self._buttons:
            sensor.sample(now_ms, 0)
            if sensor.active:
                wanted[axis] += sign
        if self._fast is not None:
            self._fast.sample(now_ms, 0)
        machine = self._machine
        self._own = self._own and machine.jogging
        if not any(wanted):
            self._dead = False
        if wanted != self._wanted:
            self._wanted = wanted
            if self._own:
                machine.carry_out(JOG_CANCEL)
        if self._dead or not any(wanted) or machine.dropping:
            return
        if self._own or machine.state == "idle" and not self._queue.lit():
            self._go_on(wanted)
        else:
            self._dead = True

    def _go_on(self, wanted):
        """Queue pieces until _AHEAD_MS of motion are queued."""
        speeds = self._jog_speeds()
        here = self._queue.position()
        for _ in range(_AHEAD_MS // _PIECE_MS):
            end = self._machine.target
            for axis in range(len(wanted)):
                if wanted[axis] and abs(end[axis] - here[axis]) * 1000 > speeds[axis] * (_AHEAD_MS - _PIECE_MS):
                    return
            if not self._queue_piece(wanted, speeds, end):
                return

    def _queue_piece(self, wanted, speeds, end):
        """Queue a piece of _PIECE_MS from `end` on, within the travel. Returns False if there is none."""
        machine = self._machine
        target = [end[axis] + wanted[axis] * max(speeds[axis] * _PIECE_MS // 1000, 1) for axis in range(len(wanted))]
        if machine.homed:
            for axis in range(len(target)):
                low, high = self._queue.reach(axis)
                target[axis] = max(low, min(high, target[axis])) if wanted[axis] else target[axis]
        deltas = [to - at for to, at in zip(target, end)]
        if not any(deltas):
            return False
        motion = Motion(JOG_TO, target)
        motion.feed = length_nm(deltas, machine.steps_per_m) * 1000 // _PIECE_MS
        error = machine.handlers[JOG_TO](motion)
        if error:
            self._dead = error != LATER
            return False
        self._own = True
        return True

    def _jog_speeds(self):
        """Return the speed of each axis in steps/s, with the fast button the highest that the settings allow."""
        if self._fast is None or not self._fast.active:
            return self._slow
        settings = self._machine.settings
        return [
            settings.value(table.STEPS + axis) * settings.value(table.SPEED + axis) // 60_000_000 for axis in range(len(self._axes))
        ]
