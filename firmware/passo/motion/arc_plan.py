"""The plan of an arc: what arc.plan() works out, once a block, for the circle's walker. An array of small integers."""

from micropython import const

PLAN = const(21)  # its size
AXIS_A, AXIS_B, AXIS_Z, MIRROR, REGION, U, W = 0, 1, 2, 3, 4, 5, 6
RADIUS, SHIFT, D, E, STEPS, DIAGONAL = 7, 8, 9, 10, 11, 12
Z_STEPS, Z_HIGH, Z_LOW, TAIL_A, TAIL_B, TAIL_Z, PATH = 13, 14, 15, 16, 17, 18, 19
PATH_FINE = 20

MAX_RADIUS = const(0x100000)  # 2²⁰ steps
MAX_SLOPE = const(128)  # most steps of the third axis along one step of the circle
LEADS = const(22_938)  # Z_HIGH from which the third axis dominates somewhere: 0.7 steps a step
FINE = const(20)  # fraction bits of a length along the circle
