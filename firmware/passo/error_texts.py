"""The meanings of the numbers of `errors`, a line each. A board loads this only if somebody asks, at the REPL.

    from passo.error_texts import text
    text(33)

Options and languages have those of their own numbers in error_texts.py of their folders.
"""

import sys

from passo import errors

TEXTS = {
    errors.NONE: "no error",
    errors.LETTER: "a number without a letter: write X10, not 10",
    errors.NUMBER: "a letter without a number, or with a wrong one: write X10.5",
    errors.STATEMENT: "there is no such $ command or setting: $ lists commands, $$ settings",
    errors.NEGATIVE: "the value must not be below zero",
    errors.HOMING_OFF: "homing is switched off: set $22=1",
    errors.STEP_PULSE: "the step pulse must last 3 µs or more",
    errors.MEMORY: "the settings could not be read or kept: the board file's hold; set them again",
    errors.BUSY: "the machine is not ready for this: wait until it stands still; in alarm home it, or unlock it",
    errors.LOCKED: "the machine is in alarm: home it first, or unlock it",
    errors.LIMITS_NEED_HOMING: "soft limits need homing: set $22=1 first",
    errors.LINE_TOO_LONG: "the line has more than 80 characters, or 127 with a row of dots, 243 with a packed one, and was not done: shorten it",
    errors.STEP_RATE: "steps/mm × speed is more than the board can step: lower one of them",
    errors.DOOR_OPEN: "the safety door is open: close it",
    errors.START_LINE_TOO_LONG: "the start-up line or text is too long to be kept: shorten it",
    errors.JOG_TRAVEL: "the target is outside the machine's travel: go less far",
    errors.JOG_WORDS: "a jog takes axes and F, and G20 G21 G53 G90 G91 only",
    errors.LASER_WITHOUT_PWM: "laser mode needs an output with PWM: the spindle's key pwm in the board file",
    errors.UNSUPPORTED: "this word or command is not supported: take another; docs/reference/gcode.md lists them",
    errors.SAME_GROUP: "two commands of the same modal group: write them in two lines",
    errors.NO_FEED: "no feed rate: give F",
    errors.NOT_INTEGER: "a value must be a whole number",
    errors.TWO_AXIS_COMMANDS: "two commands want the axis words: write them in two lines",
    errors.REPEATED_WORD: "a word stands twice: leave one out",
    errors.NO_AXIS_WORDS: "the command needs an axis word: X, Y or Z",
    errors.LINE_NUMBER: "the line number is not within 0 … 10 000 000",
    errors.VALUE_MISSING: "a word is missing: P or L; R, Z or Q of a cycle",
    errors.NO_SUCH_SYSTEM: "there is no such work coordinate system: G54 … G59",
    errors.MACHINE_COORDINATES: "G53 goes with G0 or G1 only",
    errors.AXIS_WORDS_UNUSED: "no command uses the axis words: leave them out, or give one",
    errors.NO_AXIS_IN_PLANE: "the arc needs an axis word of its plane",
    errors.TARGET: "no motion comes of these numbers: check F, Z, R, and I, J, K",
    errors.RADIUS: "the arc's radius does not reach from start to target: check R, or I J K, and the plane",
    errors.NO_CENTRE: "the arc needs R, or I, J, K of its plane",
    errors.WORDS_UNUSED: "no command uses the line's words: leave them out, or give one",
    errors.TOOL_LENGTH_AXIS: "G43.1 and G10 L1 take Z only",
    errors.TOOL_NUMBER: "the tool number is above 255: take a lower one",
    errors.NO_SUCH_TOOL: "the tool is not in the table of lengths: G10 L1 P Z puts it there",
    errors.CHECKSUM: "a packet's checksum was wrong: it was asked for again",
    errors.UNKNOWN_COMMAND: "unknown to this board",
    errors.BYTES_DROPPED: "an unfinished packet was dropped: it was asked for again",
    errors.TRAVEL: "the point lies outside the machine's travel: move or scale the drawing",
    errors.SPEED_RANGE: "the speed is outside the board file's speed.min … speed.max",
    errors.NO_HOMING: "the board file names no homing sensors: add the section homing",
    errors.NOT_HOMED: "the board file wants the machine homed first: home it",
    errors.TOO_MANY_WAITING: "too many commands sent at once: wait for the answers",
    errors.WORDS_LATE: "steps were not computed in time: the motion paused, no step was lost",
    errors.SETTING_RANGE: "the value is outside the setting's range: docs/reference/settings.md has it",
    errors.NO_PROBE: "the board file names no probe: add an input named probe",
    errors.COMMANDED_ELSEWHERE: "another link commands the machine: hand the command over first",
    errors.NO_SUCH_LINK: "the board file has no link of this number: $LINK lists them",
    errors.GARBLED: "bytes that are no whole frame were dropped",
    errors.STOPPED: "dropped, because the machine was stopped: send it again",
    errors.NO_MOTORS: "the motors are the other controller's: connect them to this board first",
    errors.HOST_LOST: "the host said nothing any more while its job was under way: the machine was held or stopped",
    errors.NUMBER_RANGE: "the number is out of its range",
    errors.INTERLOCKED: "the interlock forbids it: the log names the input",
    errors.TOOL_ON: "a setting does not change while the tool is on: switch it off first",
    errors.NO_ANSWER: "the board does not answer: look at its cable and its power",
    errors.LEASE: "the jog has ended: let go, and press again",
    errors.NO_SESSION: "this needs the key: type in the one that the panel shows in its terminal",
    errors.ORDER_FIELD: "a field of the order is missing, or out of its bounds",
    errors.NO_SUCH_JOB: "there is no job of this name",
    errors.JOB_NAME: "a job's name has letters, digits, blanks and . _ - only, begins with a letter or digit, and has at most 60",
    errors.JOB_SIZE: "the job is too large, or there is no room for it: delete others",
    errors.JOB_PIECE: "a piece of the job is missing: send it again from its beginning",
    errors.NOT_ADMITTED: "over the network this needs the key, or somebody at the machine who admits it first",
    errors.PRESENCE: "over the network this needs somebody at the machine: hold the button there",
    errors.DRAWING: "the file cannot be drawn, or does not fit on the table: run passo draw FILE --dry-run to see why",
    errors.NOT_A_JOB: "the file is empty or no text in UTF-8: a job is a program or a drawing",
    errors.NOT_WRITTEN: "the PC could not read or write its file: its disk is full, or another program has the file: free it, and try again",
    errors.NOT_SENT: "STOP is not known to have left this PC: use the emergency stop",
    errors.JOB_LINE: "a job has no $ line but $H, no real-time command (! ? ~ Ctrl-X), and letters beyond ASCII only in comments",
    errors.FOREIGN_ANSWER: "one ok too many: another program sends lines by the same port, too, and the job has been stopped; close that program",
    errors.LINK_TAKEN: "another program has taken over a TCP connection: end one of the two",
    errors.NO_MEMORY: "no memory is left for arcs: the board file's speeds take it",
    errors.ALARM_LOCKED: "locked, because the position is not known: home the machine, or unlock it",
    errors.ALARM_HARD_LIMIT: "a limit switch or the emergency stop was hit, the position may be lost: free it, reset, and home",
    errors.ALARM_SOFT_LIMIT: "the target lies outside the machine's travel: nothing moved, the position is kept; reset, and unlock",
    errors.ALARM_RESET: "reset while moving: the position may be lost; home",
    errors.ALARM_PROBE_STATE: "the probe was in contact before it began, or not in contact: check its wire, and $6",
    errors.ALARM_PROBE_MISSED: "the probe met nothing on its way: begin closer, or go further",
    errors.ALARM_HOMING_RESET: "a reset has ended homing: home again",
    errors.ALARM_HOMING_DOOR: "the safety door has ended homing: close it, and home again",
    errors.ALARM_SENSOR_STUCK: "homing: a sensor stays active though the head has left it: check the sensor, and its polarity",
    errors.ALARM_SENSOR_DEAD: "homing: no sensor answered within the travel: check the sensor, and the direction ($23)",
    errors.ALARM_TWO_MOTORS: "homing: the second motor's switch did not answer: check it",
    errors.ALARM_HOMING_REQUIRED: "locked, because not every axis is homed: home the others, or unlock the machine",
    errors.ALARM_INTERLOCK: "the interlock has stopped the machine: the log names the input; the position may be lost",
    errors.ALARM_SPINDLE_SPEED: "the spindle did not come to its speed, or lost it: check load, belt and inverter",
    errors.ALARM_HOST_LOST: "the host said nothing any more: its job was dropped at a stand; the position is kept",
    errors.ALARM_POWER: "the power fails: stopped, and the state of the job saved; passo resume goes on",
}


def text(number):
    """Return the meaning of an error or alarm `number`, in one line."""
    if number not in TEXTS:
        load()
    return TEXTS.get(number) or "error %d" % number


def load():
    """Add the texts of the options and languages that are loaded: error_texts.py of their folders."""
    for package in {".".join(name.split(".")[:3]) for name in sys.modules if name[:14] == "passo.options." or name[:16] == "passo.protocols."}:
        try:
            TEXTS.update(__import__(package + ".error_texts", None, None, ("TEXTS",)).TEXTS)
        except ImportError:
            pass
