"""The planner of a machine whose motors are not its axes: blocks come in steps of the axes, and are made in those of the motors.

    planner = motion.Planner(2, board)      # by a module of MAPS, as motion_corexy.py says
    planner.line((400, 30), …)              # as of a Planner
    planner.stand_at(motors)                # where the motors stand, whenever the machine has been stopped amid a block

Blocks lead to positions, not by distances: the step that an axis is amid when it is stopped is not lost, the next block makes it up.
Lines come as commands: a batch's rows are blocks already.
"""

from array import array

from passo.motion import planner
from passo.options.kinematics import motion_corexy as corexy
from passo.records import TICKS_PER_S

MAPS = {"corexy": corexy}  # by the value of the key

class Planner(planner.Planner):
    def __init__(self, axes, board):
        planner.Planner.__init__(self, axes)
        self.kinematics = MAPS[board["kinematics"]]
        self.own = None  # the limits of the axes
        self._end, self._goal, self._motors, self._ways = [array("i", [0] * axes) for _ in range(4)]
        self._inside = False  # line() and fits() get steps of the motors

    def limits(self, limits):
        """Take the limits of the axes; `own` keeps them, the base gets those of the motors."""
        self.own = limits
        limits = planner.Planner.limits(self, limits and self.kinematics.motor_limits(limits))
        self.ready = False
        return limits

    def slowest_limits(self, axes):
        """Return (the lowest speed of all axes in nm/s, [acceleration of each of `axes`])."""
        own = self.own
        return min(own.speeds), [own.accelerations[axis] for axis in axes]

    def stand_at(self, motors):
        """Take over where the motors stand, in steps since power-up. Nothing is queued."""
        for motor in range(self.axes):
            self._motors[motor] = motors[motor]
        self.kinematics.to_axes(motors, self._end)

    def _lead_to(self, deltas):
        """Set `_goal`, `deltas` steps of the axes beyond the queue's end, and `_ways`, the steps of the motors to it."""
        goal, ways, motors = self._goal, self._ways, self._motors
        for axis in range(self.axes):
            goal[axis] = self._end[axis] + deltas[axis]
        self.kinematics.to_motors(goal, ways)
        for motor in range(self.axes):
            ways[motor] -= motors[motor]

    def _arrive_at_goal(self):
        """Let the queue end at `_goal`."""
        for axis in range(self.axes):
            self._end[axis] = self._goal[axis]
            self._motors[axis] += self._ways[axis]

    def line(self, deltas, ticks, tool, tag=0, rapid=False, speed_nm_s=0):
        """Queue a line of `deltas` steps of the axes. See the base; raises ValueError."""
        if self._inside:
            planner.Planner.line(self, deltas, ticks, tool, tag, rapid, speed_nm_s)
            return
        self._lead_to(deltas)
        if speed_nm_s and not self.kinematics.STRAIGHT:
            ticks, speed_nm_s = ticks or self.own.length(deltas) * TICKS_PER_S // speed_nm_s or 1, 0
        planner.Planner.line(self, self._ways, ticks, tool, tag, rapid, speed_nm_s)
        self._arrive_at_goal()

    def fits(self, deltas, ticks, speed_nm_s):
        """Raise ValueError if the base would refuse the line."""
        if not self._inside:
            self._lead_to(deltas)
            deltas = self._ways
        planner.Planner.fits(self, deltas, ticks, speed_nm_s)

    def arc(self, deltas, plane, center, tool, clockwise=False, turns=0, speed_nm_s=0, ticks=0, tag=0, queued=True,
            over_half=None):
        """Queue an arc of the axes, in the plane of motors in which it is one too. Raises ValueError if there is no such plane."""
        own = self.own
        found = self.kinematics.arc_plane(plane)
        if found is None or own is None or own.steps_per_m[plane[0]] != own.steps_per_m[plane[1]]:
            raise ValueError("no plane of motors in which the arc is one")
        motors, mirrored = found
        middle = [0] * self.axes
        middle[plane[0]], middle[plane[1]] = center
        self._lead_to(middle)
        center = self._ways[motors[0]], self._ways[motors[1]]
        self._lead_to(deltas)
        self._inside = True
        try:
            planner.Planner.arc(
                self, self._ways, motors, center, tool, clockwise != mirrored, turns, speed_nm_s, ticks, tag, queued, over_half
            )
        finally:
            self._inside = False
        if queued:
            self._arrive_at_goal()
