"""CoreXY and H-bot: two motors hold one belt, and both move the head along X and along Y.

    a = x + y      x = (a + b) / 2           b ╲   ╱ a     motor a turns: the head goes along x = y
    b = x − y      y = (a − b) / 2              ╲ ╱        motor b turns: along x = −y

Any module here with these names is a machine's kinematics, by its name in the board file; only motion.py asks it:

    to_motors(axes, into) steps of the motors at a position in steps of the axes; from where the machine was switched on
    to_axes(motors, into) the other way round; amid a step the nearest below. `into` may be `motors`
    motor_limits(limits)  what the planner reckons with, a Limits of the motors: lengths along them are those of the path if STRAIGHT
    arc_plane(plane)      of an arc in the plane (a, b, third) of the axes: the plane of motors in which it is one too, and True if it goes
                          the other way round there; None: no plane is
    STRAIGHT              True if a straight move of the axes at one speed is a straight move of the motors at one speed, too
    pieces(axes, deltas)  if not STRAIGHT: how many straight pieces of the motors a line of the axes wants, from a position on

Seen from the motors the axes are turned by 45°, mirrored, and √2 as fine: lengths, angles, circles and speeds along the path stay what
they are. A motor is allowed what moves the slower axis at its limit, so each axis stays within its own, and a diagonal, which is
one motor's work, has 1/√2 of it along the path.
"""

from passo.motion.integers import isqrt
from passo.motion.limits import Limits

STRAIGHT = True


def to_motors(axes, into):
    """Write the motors' steps at the position `axes` to `into`."""
    x, y = axes[0], axes[1]
    into[0] = x + y
    into[1] = x - y
    for axis in range(2, len(axes)):
        into[axis] = axes[axis]


def to_axes(motors, into):
    """Write the axes' position, in steps, to `into`; amid a step of an axis the step below. `into` may be `motors`."""
    a, b = motors[0], motors[1]
    into[0] = a + b >> 1
    into[1] = a - b >> 1
    for axis in range(2, len(motors)):
        into[axis] = motors[axis]


def motor_limits(limits):
    """Return the Limits of the motors, which let the slower axis reach its own."""
    finest = limits.steps_per_m[0]
    finest = isqrt(2 * finest * finest)
    speed, acceleration = [isqrt(min(each[0], each[1]) ** 2 // 2) or 1 for each in (limits.speeds, limits.accelerations)]
    return Limits(
        [finest, finest] + limits.steps_per_m[2:],
        [speed, speed] + limits.speeds[2:],
        [acceleration, acceleration] + limits.accelerations[2:],
        limits.junction_deviation,
        isqrt(limits.start * limits.fastest * limits.fastest >> 28),
        limits.jerk,
    )


def arc_plane(plane):
    """Return (plane of motors, True if an arc goes the other way round there) for a plane of axes; None if there is none."""
    if plane[0] + plane[1] != 1:
        return None
    return (0, 1, plane[2]), plane[0] == 0
