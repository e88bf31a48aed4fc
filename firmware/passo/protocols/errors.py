"""Every error and alarm by number: one table for the firmware, the host tools and the documents.

Numbers up to 199 are errors: a command was refused and nothing moved. From 200 they are alarms: the machine stopped
and must be homed. Where grbl 1.1 has a number for the same thing it is that number, its alarms 200 higher.
"""

from micropython import const

NONE = const(0)
BUSY = const(8)
LOCKED = const(9)
JOG_TRAVEL = const(15)
CHECKSUM = const(101)
UNKNOWN_COMMAND = const(102)
BYTES_DROPPED = const(103)
TRAVEL = const(104)
SPEED_RANGE = const(105)
NO_HOMING = const(106)
NOT_HOMED = const(107)
TOO_MANY_WAITING = const(108)
WORDS_LATE = const(109)

ALARM_HALT_INPUT = const(201)
ALARM_SENSOR_STUCK = const(208)
ALARM_SENSOR_DEAD = const(209)

_TEXTS = {
    NONE: "no error",
    BUSY: "the machine is busy: wait until it stands still",
    LOCKED: "the machine is in alarm: home it first",
    JOG_TRAVEL: "the jog would leave the machine's travel",
    CHECKSUM: "a packet's checksum was wrong: it was asked for again",
    UNKNOWN_COMMAND: "a packet with an unknown command byte",
    BYTES_DROPPED: "an unfinished packet was dropped: it was asked for again",
    TRAVEL: "the point lies outside the machine's travel",
    SPEED_RANGE: "the speed is outside the range of the board file",
    NO_HOMING: "the board file names no homing sensors",
    NOT_HOMED: "the board file wants the machine homed before it draws",
    TOO_MANY_WAITING: "too many commands sent without waiting for their answers",
    WORDS_LATE: "steps were not computed in time: the motion paused, no step was lost",
    ALARM_HALT_INPUT: "an emergency stop or limit input became active",
    ALARM_SENSOR_STUCK: "homing: a sensor stays active though the head has left it",
    ALARM_SENSOR_DEAD: "homing: a sensor was not found within the travel",
}


def text(number):
    """What error or alarm `number` means, in one line."""
    return _TEXTS.get(number) or "error %d" % number


def numbers():
    """All numbers of the table, in order."""
    return sorted(_TEXTS)
