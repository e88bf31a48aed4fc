"""M2 and M30 of a board with `parking`, if $142 is set: up to the target, $58, before spindle and coolant go off.

    append(gcode)       # to gcode.commands

As for the door: only if $41 is set, the machine is homed, no laser, and the axis stands below the target.
"""

from passo import commands
from passo.records import SETTING_PARKING, SETTING_PARKING_AXIS, SETTING_PARKING_END, SETTING_PARKING_TARGET


def append(gcode):
    machine = gcode.machine
    value = machine.settings.value
    axis = value(SETTING_PARKING_AXIS)
    height = value(SETTING_PARKING_TARGET) * 1000  # nm
    target = list(gcode.position)
    if value(SETTING_PARKING) and value(SETTING_PARKING_END) and machine.homed and not gcode.laser and target[axis] < height:
        gcode._prepare(0, 0, 0, gcode.number, gcode.spindle, gcode.rpm)
        target[axis] = height
        gcode._go(commands.LINE, target, 0)
