"""The numbers of the settings, grbl's where it has them."""

from micropython import const

from passo.records import (
    SETTING_INCHES as INCHES, SETTING_LASER as LASER, SETTING_MAX_RPM as MAX_RPM, SETTING_REPORT as REPORT,
)  # fmt: skip

PULSE_US = const(0)
IDLE_DELAY = const(1)
STEP_INVERT = const(2)
DIRECTION_INVERT = const(3)
ENABLE_INVERT = const(4)
LIMIT_INVERT = const(5)
PROBE_INVERT = const(6)
JUNCTION = const(11)
ARC = const(12)
SOFT_LIMITS = const(20)
HARD_LIMITS = const(21)
HOMING = const(22)
HOMING_DIRECTION = const(23)
HOMING_LOCATE = const(24)
HOMING_SEEK = const(25)
HOMING_DEBOUNCE = const(26)
HOMING_PULL_OFF = const(27)
MIN_RPM = const(31)
STEPS = const(100)
SPEED = const(110)
ACCELERATION = const(120)
TRAVEL = const(130)
START = const(140)  # Passo's own, and the next
JERK = const(141)
