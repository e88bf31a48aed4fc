"""The fields of this option's arrays, as passo/records.py has those of the core."""

from micropython import const

# Behind it in Ramp.state if jerk is limited (motion.py). b is the square root of the speed, in the block's units, that would
# come on top while the acceleration fades. Of the block:
S_CURVE_B = const(17)
S_CURVE_RATE = const(18)  # the change of b in a tick: S_CURVE_RATE / 2 ** S_CURVE_RATE_SHIFT
S_CURVE_RATE_SHIFT = const(19)
S_CURVE_PUSH = const(20)  # the change of q by b in a step: b · S_CURVE_PUSH / 2 ** 11
S_CURVE_MOST = const(21)  # b at the highest acceleration
S_CURVE_LIMIT = const(22)  # no b is larger
S_CURVE_W = const(23)  # the speed that acceleration takes to come and go
S_CURVE_SLOW = const(24)  # 1: w is above any speed; then need() has other units
S_CURVE_SCALE = const(25)  # of need(), a step
S_CURVE_FIRST = const(26)  # b and q after one step from rest; 0: step_from_rest() has not been asked yet
S_CURVE_REST = const(27)
S_CURVE_HALF = const(28)  # of the speed there to its mean one, · 2¹³
S_CURVE_SPARE = const(29)  # the growth of b below one
S_CURVE_CRUISE = const(30)  # a steady speed that need() has been asked for, the end, and the result
S_CURVE_CRUISE_UNTIL = const(31)
S_CURVE_CRUISE_NEED = const(32)
S_CURVE_BEHIND = const(33)  # the index of the row of the block behind
S_CURVE_SPAN = const(34)  # its ROW_SPAN
# Of the segment:
S_CURVE_UNTIL = const(35)  # speed at the block's end
S_CURVE_ON = const(36)  # 1: slowing down goes on in the block behind
S_CURVE_ROOM = const(37)  # the rest of the block, in the units of need()
S_CURVE_FORCE = const(38)  # S_CURVE_PUSH along its path
S_CURVE_FAST = const(39)  # the speed wanted
S_CURVE_AIM = const(40)  # q last tried to end with
S_CURVE_SPEED = const(41)  # its root; -1: not known
S_CURVE_ABOVE = const(42)  # how much speed is above the one wanted then
S_CURVE_LEAVE = const(43)  # the block's planned exit, q
S_CURVE_GROW = const(44)  # the most change of b
S_CURVE_GUESS = const(45)  # speed at its end if b stays
S_CURVE_BRAKES = const(46)  # 1: it has to slow down for the path ahead
# Of the machine: √(jerk / 2) a tick, in fastest / 2²⁸: S_CURVE_ROOT / 2 ** S_CURVE_SHIFT; the planner's rows.
S_CURVE_ROOT = const(47)
S_CURVE_SHIFT = const(48)
S_CURVE_STRIDE = const(49)
S_CURVE_ROWS = const(50)  # integers of all rows
S_CURVE_FIELDS = const(51)
