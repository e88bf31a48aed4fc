"""The kinematics of a polar plotter, as passo/options/kinematics/motion_corexy.py says: a turntable below a pen that slides. Only tests have it.

Motor X slides, motor Y turns. The table's middle lies POLE_MM left of the place where the machine was switched on; where the pen
does not go beyond it, the angle is the one between −90° and 90°.
"""

from math import atan2, cos, hypot, pi, sin, sqrt

from passo.motion.limits import Limits

STRAIGHT = False
STEPS_MM, TURN_STEPS, POLE_MM = 80, 25_600, 60
FAR_MM = 300
_PIECE = 80  # steps of the axes, 1 mm


def to_motors(axes, into):
    x, y = axes[0] + POLE_MM * STEPS_MM, axes[1]
    into[0] = round(hypot(x, y)) - POLE_MM * STEPS_MM
    into[1] = round(atan2(y, x) / (2 * pi) * TURN_STEPS)


def to_axes(motors, into):
    far, angle = motors[0] + POLE_MM * STEPS_MM, motors[1] * 2 * pi / TURN_STEPS
    into[0] = round(far * cos(angle)) - POLE_MM * STEPS_MM
    into[1] = round(far * sin(angle))


def motor_limits(limits):
    """A turn counts as the way of the farthest place."""
    per_m = round(TURN_STEPS / (2 * pi * FAR_MM / 1000))
    return Limits([limits.steps_per_m[0], per_m], limits.speeds, limits.accelerations, limits.junction_deviation, 0, limits.jerk)


def arc_plane(plane):
    return None


def pieces(axes, deltas):
    return int(sqrt(deltas[0] * deltas[0] + deltas[1] * deltas[1])) // _PIECE + 1
