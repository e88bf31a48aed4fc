"""M2 and M30 go up to the target, $58, before spindle and coolant go off: if $142 says so, and else as for the door only if $41 is set, the
machine is homed, no laser, and the axis stands below the target."""

from micropython import const

_PARKING = const(41)  # settings
_AXIS = const(42)
_TARGET = const(58)
_AT_END = const(142)


def extend(protocol, board):
    """Have M2 and M30 of a link retract first."""
    protocol.gcode.at_end = retract


def retract(gcode):
    """Append the motion up to the target, if one is due. Raises Refused."""
    value = gcode.machine.settings.value
    axis = value(_AXIS)
    height = value(_TARGET) * 1000  # nm
    target = list(gcode.position)
    if value(_PARKING) and value(_AT_END) and gcode.machine.homed and not gcode.laser and target[axis] < height:
        target[axis] = height
        gcode.add_rapid(target)
