"""Numbers of the settings of `parking`; those from 41 to 59 are grblHAL's."""

from micropython import const

ON = const(41)  # 1: it parks
AXIS = const(42)
PULL_OUT = const(56)
PULL_OUT_SPEED = const(57)
HEIGHT = const(58)  # the target, machine coordinate
SPEED = const(59)
AT_END = const(142)  # 1: M2 and M30 go to the target, too
