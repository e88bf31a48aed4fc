"""The vocabulary that all languages share: the commands to the machine, and its answers.

A protocol turns bytes into Commands and Events into bytes; the controller turns Commands into Events. Bytes that a protocol could not
understand become a Command, too, BAD with the number of the error, so that it is logged and answered like others.

Places are steps of each axis from machine position zero; speeds are nanometres a second along the path.
"""

from micropython import const

# Questions, and bytes without a command.
BAD = const(0)  # `error`: why the bytes were no command
HELLO = const(1)  # is the controller there?
STATUS = const(2)  # state, last error, position
# Of every machine.
STOP = const(3)  # stop now, tool off, drop what was stored
HOME = const(4)
# Drawings, whose points are stored.
SPEED = const(5)  # `value`: drawing speed, in the unit of the board file
POINT = const(6)  # `target` in steps from the origin, `tool`: append to the stored object
DRAW = const(7)  # draw the stored object to its end, then clear it
JOG = const(8)  # `target`: direction of each axis, −1, 0 or +1; the distance is the board file's
# Motion and waits, one behind the other.
LINE = const(9)  # to `target` at `feed`
ARC = const(10)  # to `target` at `feed`, about a centre: see Motion
JOG_TO = const(11)  # as LINE, only from rest or behind another jog; JOG_CANCEL drops it
PROBE = const(12)  # as LINE, until the probe changes; `value`: bit 0 until contact is lost, bit 1 a miss is no alarm
DWELL = const(13)  # `value` microseconds after everything before it has ended; 0: only that
PAUSE = const(14)  # everything before it ends, then the machine waits for RESUME; `value`: 1 + the tool to be put in, or 0
# Outputs, in their turn.
SPINDLE = const(15)  # `value`: 3 clockwise, 4 counter-clockwise, 5 off; `power` in millionths of the most, `tool`: lit now
COOLANT = const(16)  # `value`: bit 0 flood, bit 1 mist
# At any moment.
HOLD = const(17)  # come to a stand on the path
RESUME = const(18)  # go on after HOLD, PAUSE or DOOR
DOOR = const(19)  # as HOLD, the tool off as well
JOG_CANCEL = const(20)
RESET = const(21)  # stop now, forget everything queued
UNLOCK = const(22)  # leave the alarm without homing
OVERRIDE = const(23)  # `value`: one of FEED … ALL below, `power`: the percentage, or 0 and `feed`: the change of it
TOGGLE = const(24)  # while moving: `value` as COOLANT, toggled; SPINDLE_STOP in a hold
CHECK = const(25)  # `value` 1: commands are only checked from now on; 0: they are carried out again
SLEEP = const(26)  # everything off until RESET
# Of the link.
SYNC = const(27)  # an answer only, once everything before it has ended
HAND_OVER = const(28)  # `value`: the link that may command from now on, the board file's first is 1; 0: this one
# Axes on their own, and the controller of the motors.
RUN = const(29)  # axes run on their own from now on: see Run
CONNECT = const(32)  # `value` 1: the motors are this board's; 0: they are the other controller's
# Settings.
STILL = const(33)  # accepted at a stand, else refused as BUSY; `value`: (steps, steps/s) of a jog of each axis, which are kept, or 0
SETTING = const(35)  # `target`: its number, None: which there are; `value`: in thousandths, None: tell it, or `tool`: as the board file has it
MORE = const(36)  # no command: `value` makes the line's next one each time it is asked, next(value), then None
# Of the network.
ADMIT = const(39)  # `value` minutes: programs without a key may move the machine over the network, if the board file allows that
# Of the journal of stored jobs.
JOURNAL = const(51)  # of the job: `target` None: tell it; else the number of the job that begins
# Lines of G-code that features bring.
CODE = const(1000)  # + 62: M62, as the line of G-code says it: `value` is its number, see protocols/gcode/codes.py; M66: `power` is L, `feed` Q in ms

# Inputs of the board file whose name means something: its letter in a status report, the command that it sends as it becomes active
# (BAD: none), and the feature that this wants.
INPUTS = (
    ("probe", "P", BAD, ""),
    ("door", "D", DOOR, "pauses"),
    ("hold", "H", HOLD, "pauses"),
    ("reset", "R", RESET, "resets"),
    ("resume", "S", RESUME, "pauses"),
)

# A word of some machines in a status: its key in the report, to which a feature's report() puts a value, or None; the word
# for it in grbl's report, the status of pulses, the torch's /INFO and the page. The plotter's and the torch's packets have no room for
# more words. A feature of few machines appends its own row.
STATUS_WORDS = [
    ("job", "SD"),  # a stored job: "per cent,name"
    ("counts", "En"),  # of encoders
    ("rpm", "RPM"),  # of a tachometer
    ("glitches", "Gl"),  # of an interlock's inputs
    ("alarm", "Al"),  # its number, while there is one
    ("unhomed", "Nh"),  # letters of the axes that are not homed
]

SPINDLE_OFF = const(5)  # a SPINDLE's value

FEED = const(0)
RAPID = const(1)
POWER = const(2)
ALL = const(3)
SPINDLE_STOP = const(4)  # TOGGLE

# The position in a job, as a feature's progress() gives it to the journal: fields of an array, see options/journal/control.py.
SPOT_INDEX = const(0)  # units done
SPOT_TIMES = const(1)  # times to be played, this one included
SPOT_BACK = const(2)  # 1: towards the start
SPOT_AXES = const(3)  # steps of each axis from here on

ACCEPTED = const(0)
REFUSED = const(1)  # `error` says why; nothing moved
FINISHED = const(2)  # a command that takes time has done what it was asked
ALARM = const(3)  # pushed to every link, `command` None: `error` is the alarm's number
NOTICE = const(4)  # pushed to every link, `command` None: `error` is one of the notices of errors.py
RESTARTED = const(5)  # pushed to every link after a RESET, `command` None
DROPPED = const(6)  # pushed to every link, `command` None: the commands it sent before are dropped; `error` has the reason,
# `value` is the Command that brought it about


class Command:
    reply = None  # the Event ACCEPTED, of a Command that is sent again and again
    ends = False  # COOLANT: of a program's end

    def __init__(self, kind, target=None, value=0, tool=False, error=0):
        self.kind = kind
        self.target = target
        self.value = value
        self.tool = tool
        self.error = error
        self.power = 0
        self.feed = 0
        self.link = None  # set by the app: where the answer goes


class Motion(Command):
    """LINE, ARC, JOG_TO, PROBE.

    `feed` 0 is as fast as the axes may; `per_min`, where not 0, is the time instead: the motion lasts a minute /
    per_min × 1000. `tool` and `power` hold from the motion's start, `dynamic`: power follows the speed. `number` is the
    line of the programme. Arcs lie in the plane of the axes `first` and `second`; `centre` is the vector from the
    start to the centre in steps, the third axis goes in proportion to the swept angle, `turns` is 1 for up to a whole
    turn, and one more for each turn beyond it; `over_half`: the last of them sweeps more than half a turn, which whole steps
    cannot tell where it begins and ends at the same one. `also`: the LINEs that follow from the same line of the programme; all
    of them are checked before this one begins.
    """

    also = ()
    dots = ()  # a LINE's powers at equal distances along it, in thousandths; `tool` and `power` are those of the last
    measures = False  # a PROBE that finds a tool's length

    def __init__(self, kind, target=None):
        Command.__init__(self, kind, target)
        self.per_min = 0
        self.dynamic = False
        self.number = 0
        self.first = 0
        self.second = 1
        self.clockwise = False
        self.centre = (0, 0)
        self.turns = 1
        self.over_half = False


def thousandths(power):
    """Return a command's power, which is in millionths, in thousandths: at least 1 if it is not off."""
    return max((power + 500) // 1000, 1) if power else 0


class Event:
    def __init__(self, kind, command, error=0, value=None):
        self.kind = kind
        self.command = command
        self.error = error
        self.value = value  # STATUS, and the end of STOP: the report, or the part of it that tells of motion
