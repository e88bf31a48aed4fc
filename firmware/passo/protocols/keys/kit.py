"""The kit of two motors, which is controlled by keys."""

from micropython import const

KIT_MOTORS = const(2)
KIT_STEP_MS = const(4)  # between steps at speed 1
KIT_SLOWEST = const(127)  # speed
