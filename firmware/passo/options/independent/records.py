"""The fields of this option's arrays, as passo/records.py has those of the core."""

from micropython import const

# The state of independent axes: these, then AXIS_FIELDS numbers an axis.
INDEPENDENT_AXES = const(0)
INDEPENDENT_LEAST = const(1)  # ticks: no word is shorter; steps that fall due within it share a word
INDEPENDENT_SETUP = const(2)  # ticks from a change of direction to the axis's next step, sharing allowed for
INDEPENDENT_LEVELS = const(3)  # directions and tool, step form
INDEPENDENT_TICKS = const(4)  # length of the segment written
INDEPENDENT_HOLD = const(5)  # 1: come to a stand, and keep what is to come
INDEPENDENT_AXIS = const(6)  # the first axis
AXIS_TO_GO = const(0)  # steps to come; endless: at least 1
AXIS_ENDLESS = const(1)  # 1: no end
AXIS_TAKEN = const(2)  # how far AXIS_ASKED has been taken up
AXIS_DUE = const(3)  # ticks to the next step
AXIS_EACH = const(4)  # ticks of an interval: AXIS_EACH + AXIS_REST / AXIS_OVER
AXIS_REST = const(5)
AXIS_OVER = const(6)
AXIS_CARRY = const(7)
AXIS_NEGATIVE = const(8)  # 1: backwards
AXIS_Q = const(9)  # square of its speed, in units of its fastest / 16 000
AXIS_AIM = const(10)  # q of the rate asked for
AXIS_GAIN = const(11)  # q a step; 0: constant rate
AXIS_SPAN = const(12)  # ticks of an interval · √q
AXIS_NEAR = const(13)  # steps from which on gain · steps may be below any q
AXIS_ASKED = const(14)  # all steps ever asked for, modulo 2²⁹: the main loop writes it, and the request:
AXIS_NEW = const(15)  # 1: there is one, as the fields of the same names
AXIS_NEW_EACH = const(16)
AXIS_NEW_REST = const(17)
AXIS_NEW_OVER = const(18)
AXIS_NEW_NEGATIVE = const(19)
AXIS_NEW_ENDLESS = const(20)
AXIS_NEW_AIM = const(21)
AXIS_NEW_BASE = const(22)  # the steps asked for up to here are dropped; −1: none are
AXIS_FIELDS = const(23)
