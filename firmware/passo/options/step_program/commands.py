"""The commands of this option, by number, behind those of passo/commands.py."""

from micropython import const

STEP_PROGRAM_ADD = const(40)  # a step program comes: `value` is one of STEPS_OPEN … STEPS_ABORT
STEP_PROGRAM = const(41)  # `value`: what to do with it, one of STEPS_GO … STEPS_HAND_DRIVES

# STEP_PROGRAM_ADD
STEPS_OPEN = const(0)  # `tool`: it is played as it comes, else stored whole
STEPS_ITEMS = const(1)  # `target`: list of items, see below
STEPS_CLOSE = const(2)  # it is complete
STEPS_ABORT = const(3)  # it cannot be understood: `error` has the reason; the part under way stops

# An item: single steps are `count << 8 | negative << 4 | mask of axes`; without axes it is `value << 8 | one of these << 4`.
STEPS_WAIT = const(1)  # ms
STEPS_TOOL = const(2)  # 1 on, 0 off
STEPS_SPEED = const(3)  # mm/min along the path; above the fastest it is that
STEPS_FASTEST = const(4)
STEPS_DEFAULT = const(5)  # the speed of the board file
STEPS_DRIVES = const(6)  # 1 on, 0 off
STEPS_ASK = const(7)  # the operator sets the speed

# STEP_PROGRAM: what to do with it
STEPS_GO = const(0)  # `tool`: backward; `power`: how many times, 0: as set
STEPS_STEP = const(1)  # one unit; `tool`: backward
STEPS_RETURN = const(2)  # the way back of the manual moves, then on; `tool`: backward
STEPS_CONTINUE = const(3)  # from here, forget the manual moves; `tool`: backward
STEPS_PASSES = const(4)  # `power`: how many times, 1 … 100
STEPS_PACE = const(5)  # `feed`: mm/min from now on to the next speed of the program
STEPS_JOG = const(6)  # `target`: steps of each axis, one axis after the other
STEPS_HAND_TOOL = const(7)  # `tool`
STEPS_HAND_DRIVES = const(8)  # `tool`: on
