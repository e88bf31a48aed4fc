"""Every error and alarm by number: one table for the firmware, the host tools and the documents.

Numbers up to 199 are errors: a command was refused and nothing moved. From 200 they are alarms: the machine stopped
and must be homed. Where grbl 1.1 has a number for the same thing it is that number, its alarms 200 higher.
"""

from micropython import const

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
NEED_RESET = (ALARM_HARD_LIMIT, ALARM_SOFT_LIMIT)

# Notices are no errors: the machine tells what it did of its own accord.
NOTICE_RESET_TO_CONTINUE = const(1)
NOTICE_LOCKED = const(2)
NOTICE_UNLOCKED = const(3)
NOTICE_CHECK_ON = const(4)
NOTICE_CHECK_OFF = const(5)
NOTICE_DOOR = const(6)
NOTICE_LIMITS = const(7)
NOTICE_SLEEPING = const(8)

_TEXTS = {
    NONE: "no error",
    LETTER: "a word begins with a letter, and none stands there",
    NUMBER: "a word's number is missing or is no number",
    STATEMENT: "there is no such $ command or setting",
    NEGATIVE: "a value below zero where it must not be",
    HOMING_OFF: "homing is switched off: set $22=1",
    STEP_PULSE: "the step pulse must last 3 µs or more",
    MEMORY: "the settings could not be read: the board file's hold",
    BUSY: "the machine is busy: wait until it stands still",
    LOCKED: "the machine is in alarm: home it first, or unlock it",
    LIMITS_NEED_HOMING: "soft limits need homing: set $22=1 first",
    LINE_TOO_LONG: "a line of more than 80 characters: nothing of it was done",
    STEP_RATE: "steps/mm × speed is more than the board can step",
    DOOR_OPEN: "the safety door is open",
    START_LINE_TOO_LONG: "a start-up line or text is too long to be kept",
    JOG_TRAVEL: "the jog would leave the machine's travel",
    JOG_WORDS: "a jog takes axes and F, and G20 G21 G53 G90 G91 only",
    LASER_WITHOUT_PWM: "laser mode needs an output with PWM",
    UNSUPPORTED: "a word or command that is not supported",
    SAME_GROUP: "two commands of the same modal group",
    NO_FEED: "no feed rate: give F",
    NOT_INTEGER: "a value must be a whole number",
    TWO_AXIS_COMMANDS: "two commands want the axis words",
    REPEATED_WORD: "a word stands twice",
    NO_AXIS_WORDS: "the command needs an axis word",
    LINE_NUMBER: "the line number is not within 0 … 10 000 000",
    VALUE_MISSING: "the command needs a P or L word",
    NO_SUCH_SYSTEM: "there is no such work coordinate system: G54 … G59",
    MACHINE_COORDINATES: "G53 goes with G0 or G1 only",
    AXIS_WORDS_UNUSED: "axis words that no command uses",
    NO_AXIS_IN_PLANE: "the arc needs an axis word of its plane",
    TARGET: "the target cannot be reached so",
    RADIUS: "the arc's radius does not reach from start to target",
    NO_CENTRE: "the arc needs R, or I, J, K of its plane",
    WORDS_UNUSED: "words that no command uses",
    TOOL_LENGTH_AXIS: "G43.1 takes Z only",
    TOOL_NUMBER: "the tool number is above 255",
    CHECKSUM: "a packet's checksum was wrong: it was asked for again",
    UNKNOWN_COMMAND: "a packet with an unknown command byte",
    BYTES_DROPPED: "an unfinished packet was dropped: it was asked for again",
    TRAVEL: "the point lies outside the machine's travel",
    SPEED_RANGE: "the speed is outside the range of the board file",
    NO_HOMING: "the board file names no homing sensors",
    NOT_HOMED: "the board file wants the machine homed before it draws",
    TOO_MANY_WAITING: "too many commands sent without waiting for their answers",
    WORDS_LATE: "steps were not computed in time: the motion paused, no step was lost",
    SETTING_RANGE: "the value is outside the setting's range",
    NO_PROBE: "the board file names no probe",
    ALARM_LOCKED: "locked: where the machine stands is not known until it is homed",
    ALARM_HARD_LIMIT: "a limit switch or the emergency stop was hit: the position may be lost",
    ALARM_SOFT_LIMIT: "the target lies outside the machine's travel: nothing moved, the position is kept",
    ALARM_RESET: "reset while moving: the position may be lost",
    ALARM_PROBE_STATE: "the probe was not in the state it must begin in",
    ALARM_PROBE_MISSED: "the probe met nothing on its way",
    ALARM_HOMING_RESET: "homing was ended by a reset",
    ALARM_HOMING_DOOR: "homing was ended by the safety door",
    ALARM_SENSOR_STUCK: "homing: a sensor stays active though the head has left it",
    ALARM_SENSOR_DEAD: "homing: a sensor was not found within the travel",
    ALARM_TWO_MOTORS: "homing: the second motor's switch was not found",
}


def text(number):
    """What error or alarm `number` means, in one line."""
    return _TEXTS.get(number) or "error %d" % number


def numbers():
    """All numbers of the table, in order."""
    return sorted(_TEXTS)
