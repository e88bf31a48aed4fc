"""M2 and M30 go up to the target, $58, before spindle and coolant go off: if $142 says so, and else as for the door only if $41 is set, the
machine is homed, no laser, and the axis stands below the target."""

from passo.options.parking.config import AT_END, AXIS, HEIGHT, ON


def extend(protocol, board):
    """Have M2 and M30 of a link retract first."""
    protocol.gcode.at_end = retract


def retract(gcode):
    """Append the motion up to the target, if one is due. Raises Refused."""
    value = gcode.machine.settings.value
    axis = value(AXIS)
    height = value(HEIGHT) * 1000  # nm
    target = list(gcode.position)
    if value(ON) and value(AT_END) and gcode.machine.homed and not gcode.laser and target[axis] < height:
        target[axis] = height
        gcode.add_rapid(target)
