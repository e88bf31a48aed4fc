"""Every error and alarm by number: one table for the firmware, the host tools and the documents. Their meanings are in `error_texts`, which
a board loads only when somebody asks.

Numbers up to 199 are errors: a command was refused and nothing moved. From 200 they are alarms: the machine stopped
and must be homed. If grbl 1.1 has a number for the same thing it is that number, its alarms 200 higher. Numbers that only an option or a
language uses lie in errors.py of its folder.
"""

from micropython import const

LATER = const(-1)  # no error: the command cannot be taken yet, ask again
NONE = const(0)
LETTER = const(1)
NUMBER = const(2)
STATEMENT = const(3)
NEGATIVE = const(4)
HOMING_OFF = const(5)
STEP_PULSE = const(6)
MEMORY = const(7)
BUSY = const(8)
LOCKED = const(9)
LIMITS_NEED_HOMING = const(10)
LINE_TOO_LONG = const(11)
STEP_RATE = const(12)
DOOR_OPEN = const(13)
START_LINE_TOO_LONG = const(14)
JOG_TRAVEL = const(15)
JOG_WORDS = const(16)
LASER_WITHOUT_PWM = const(17)
UNSUPPORTED = const(20)
SAME_GROUP = const(21)
NO_FEED = const(22)
NOT_INTEGER = const(23)
TWO_AXIS_COMMANDS = const(24)
REPEATED_WORD = const(25)
NO_AXIS_WORDS = const(26)
LINE_NUMBER = const(27)
VALUE_MISSING = const(28)
NO_SUCH_SYSTEM = const(29)
MACHINE_COORDINATES = const(30)
AXIS_WORDS_UNUSED = const(31)
NO_AXIS_IN_PLANE = const(32)
TARGET = const(33)
RADIUS = const(34)
NO_CENTRE = const(35)
WORDS_UNUSED = const(36)
TOOL_LENGTH_AXIS = const(37)
TOOL_NUMBER = const(38)
NO_SUCH_TOOL = const(39)
CHECKSUM = const(101)
UNKNOWN_COMMAND = const(102)
BYTES_DROPPED = const(103)
TRAVEL = const(104)
SPEED_RANGE = const(105)
NO_HOMING = const(106)
NOT_HOMED = const(107)
TOO_MANY_WAITING = const(108)
WORDS_LATE = const(109)
SETTING_RANGE = const(110)
NO_PROBE = const(111)
COMMANDED_ELSEWHERE = const(112)
NO_SUCH_LINK = const(113)
GARBLED = const(115)
STOPPED = const(116)
NO_MOTORS = const(117)
HOST_LOST = const(118)
NUMBER_RANGE = const(122)
NO_MEMORY = const(129)
INTERLOCKED = const(131)
TOOL_ON = const(133)
NO_ANSWER = const(170)
LEASE = const(171)
NO_SESSION = const(172)
ORDER_FIELD = const(173)
NO_SUCH_JOB = const(174)
JOB_NAME = const(175)
JOB_SIZE = const(176)
JOB_PIECE = const(177)
NOT_ADMITTED = const(178)
PRESENCE = const(179)
DRAWING = const(180)
NOT_A_JOB = const(181)
NOT_WRITTEN = const(182)
NOT_SENT = const(183)
JOB_LINE = const(184)
FOREIGN_ANSWER = const(185)
LINK_TAKEN = const(186)

ALARM_LOCKED = const(200)
ALARM_HARD_LIMIT = const(201)
ALARM_SOFT_LIMIT = const(202)
ALARM_RESET = const(203)
ALARM_PROBE_STATE = const(204)
ALARM_PROBE_MISSED = const(205)
ALARM_HOMING_RESET = const(206)
ALARM_HOMING_DOOR = const(207)
ALARM_SENSOR_STUCK = const(208)
ALARM_SENSOR_DEAD = const(209)
ALARM_TWO_MOTORS = const(210)
ALARM_HOMING_REQUIRED = const(211)
ALARM_INTERLOCK = const(220)
ALARM_SPINDLE_SPEED = const(244)
ALARM_HOST_LOST = const(250)
ALARM_POWER = const(251)
# Ways in which an alarm differs from a stop at once that releases the motors.
AT_STAND, KEEPS_CURRENT, NEEDS_RESET, OUTPUTS_OFF = 1, 2, 4, 8
# AT_STAND: the machine comes to its stand, and keeps its position; OUTPUTS_OFF: there its outputs go off. NEEDS_RESET: only a reset ends it.
# Options add their own alarms.
ALARMS = {
    ALARM_HARD_LIMIT: KEEPS_CURRENT | NEEDS_RESET, ALARM_SOFT_LIMIT: AT_STAND | NEEDS_RESET, ALARM_RESET: KEEPS_CURRENT,
    ALARM_PROBE_STATE: AT_STAND, ALARM_PROBE_MISSED: AT_STAND, ALARM_HOST_LOST: AT_STAND | OUTPUTS_OFF,
    ALARM_INTERLOCK: KEEPS_CURRENT | NEEDS_RESET,
}  # fmt: skip
# Switches and encoders are watched, and the motors stay this board's, for the position of some axes is known.
WATCHED = (NONE, ALARM_HOMING_REQUIRED)

# Notices are no errors: the machine tells what it did of its own accord.
NOTICE_RESET_TO_CONTINUE = const(1)
NOTICE_LOCKED = const(2)
NOTICE_UNLOCKED = const(3)
NOTICE_CHECK_ON = const(4)
NOTICE_CHECK_OFF = const(5)
NOTICE_DOOR = const(6)
NOTICE_LIMITS = const(7)
NOTICE_SLEEPING = const(8)
NOTICE_HANDED_OVER = const(9)
NOTICE_PAUSE = const(10)
NOTICE_TOOL = const(11)  # with the number of the tool
NOTICE_SPINDLE = const(12)
NOTICE_HOMING_REQUIRED = const(16)  # with the names of the axes
NOTICE_NO_LIMITS = const(17)
