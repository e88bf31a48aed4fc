"""The G and M codes of RS274/NGC with their modal groups, in tenths: 431 is G43.1."""

NON_MODAL, MOTION, PLANE, DISTANCE, ARC_DISTANCE, FEED_MODE, UNITS, CUTTER, LENGTH, RETURN, SYSTEM, PATH, SPINDLE_MODE, LATHE = range(14)
STOPPING, CHANGE, TURNING, COOLING, OVERRIDES, SWITCHING, CALLING, SAVING = range(20, 28)

CYCLES = (730, 740, 810, 820, 830, 840, 850, 860, 880, 890)
SPLINES = (50, 51, 52)
PROBES = (382, 383, 384, 385)
_G = {
    NON_MODAL: (40, 100, 280, 281, 300, 301, 530, 920, 921),
    MOTION: (0, 10, 20, 30, *SPLINES, 53, 800, *PROBES, *CYCLES),
    PLANE: (170, 180, 190),
    DISTANCE: (900, 910),
    ARC_DISTANCE: (901, 911),
    FEED_MODE: (930, 940, 950),
    UNITS: (200, 210),
    CUTTER: (400, 410, 411, 420, 421),
    LENGTH: (430, 431, 432, 490),
    RETURN: (980, 990),
    SYSTEM: (540, 550, 560, 570, 580, 590),
    PATH: (610, 611, 640),
    SPINDLE_MODE: (970,),
    LATHE: (80,),
}
_M = {
    STOPPING: (0, 10, 20, 300, 600),
    CHANGE: (60, 610),
    TURNING: (30, 40, 50),
    COOLING: (70, 80, 90),
    OVERRIDES: (480, 490, 500, 510, 520, 530),
    SWITCHING: (100, 110, 620, 630, 640, 650, 660),
    CALLING: (980, 990),
    SAVING: (700, 710, 720, 730),
}
G_GROUPS = {code: group for group, codes in _G.items() for code in codes}
M_GROUPS = {code: group for group, codes in _M.items() for code in codes}

# Words of RS274/NGC that no Passo machine can do, and why.
NOT_ON_BOARD = {
    "g": {
        70: "diameters of a lathe", 171: "axes U, V, W", 181: "axes U, V, W",
        191: "axes U, V, W", 330: "a spindle with an encoder", 331: "a spindle with an encoder", 591: "G54 to G59 only",
        592: "G54 to G59 only", 593: "G54 to G59 only", 760: "a spindle with an encoder", 870: "a spindle that stops at an angle",
        922: "G92 offsets are not kept", 923: "G92 offsets are not kept", 960: "constant surface speed",
    },
    "m": {190: "a spindle that stops at an angle", 670: "analogue outputs", 680: "analogue outputs"},
}  # fmt: skip

# The code that takes the line's axis words.
AXIS_COMMANDS = {0, 10, 20, 30, *SPLINES, *PROBES, *CYCLES, 100, 280, 300, 431, 432, 920}
