"""`planning.s_curves` True: the jerk of ramps can be limited, by the setting $141."""

HEAP_KB = 2  # of a Pico with stock MicroPython
RULES = {}


def check(board):
    """Have the ramps of accelerated motion keep to a jerk; add $141, mm/s³, 0: any."""
    board["additions"].ramp = "passo.options.planning_s_curves.motion"
    board["additions"].settings[141] = "jerk", 3, 0, 0, 999_999_999
