"""What the numbers of `errors` mean, a line each. A board loads this only if somebody asks, at the REPL.

    from passo.error_texts import text
    text(33)
"""

from passo import errors

TEXTS = {
    errors.NONE: "no error",
    errors.LETTER: "a word begins with a letter, and none stands there",
    errors.NUMBER: "a word's number is missing or is no number",
    errors.STATEMENT: "there is no such $ command or setting",
    errors.NEGATIVE: "a value below zero where it must not be",
    errors.HOMING_OFF: "homing is switched off: set $22=1",
    errors.STEP_PULSE: "the step pulse must last 3 µs or more",
    errors.MEMORY: "the settings could not be read, or not be kept: the board file's hold",
    errors.BUSY: "the machine is busy: wait until it stands still",
    errors.LOCKED: "the machine is in alarm: home it first, or unlock it",
    errors.LIMITS_NEED_HOMING: "soft limits need homing: set $22=1 first",
    errors.LINE_TOO_LONG: "a line of more than 80 characters: nothing of it was done",
    errors.STEP_RATE: "steps/mm × speed is more than the board can step",
    errors.DOOR_OPEN: "the safety door is open",
    errors.START_LINE_TOO_LONG: "a start-up line or text is too long to be kept",
    errors.JOG_TRAVEL: "the jog would leave the machine's travel",
    errors.JOG_WORDS: "a jog takes axes and F, and G20 G21 G53 G90 G91 only",
    errors.LASER_WITHOUT_PWM: "laser mode needs an output with PWM",
    errors.UNSUPPORTED: "a word or command that is not supported",
    errors.SAME_GROUP: "two commands of the same modal group",
    errors.NO_FEED: "no feed rate: give F",
    errors.NOT_INTEGER: "a value must be a whole number",
    errors.TWO_AXIS_COMMANDS: "two commands want the axis words",
    errors.REPEATED_WORD: "a word stands twice",
    errors.NO_AXIS_WORDS: "the command needs an axis word",
    errors.LINE_NUMBER: "the line number is not within 0 … 10 000 000",
    errors.VALUE_MISSING: "the command needs a P or L word",
    errors.NO_SUCH_SYSTEM: "there is no such work coordinate system: G54 … G59",
    errors.MACHINE_COORDINATES: "G53 goes with G0 or G1 only",
    errors.AXIS_WORDS_UNUSED: "axis words that no command uses",
    errors.NO_AXIS_IN_PLANE: "the arc needs an axis word of its plane",
    errors.TARGET: "the target cannot be reached so",
    errors.RADIUS: "the arc's radius does not reach from start to target",
    errors.NO_CENTRE: "the arc needs R, or I, J, K of its plane",
    errors.WORDS_UNUSED: "words that no command uses",
    errors.TOOL_LENGTH_AXIS: "G43.1 takes Z only",
    errors.TOOL_NUMBER: "the tool number is above 255",
    errors.CHECKSUM: "a packet's checksum was wrong: it was asked for again",
    errors.UNKNOWN_COMMAND: "an unknown command byte",
    errors.BYTES_DROPPED: "an unfinished packet was dropped: it was asked for again",
    errors.TRAVEL: "the point lies outside the machine's travel",
    errors.SPEED_RANGE: "the speed is outside the range of the board file",
    errors.NO_HOMING: "the board file names no homing sensors",
    errors.NOT_HOMED: "the board file wants the machine homed before it draws",
    errors.TOO_MANY_WAITING: "too many commands sent without waiting for their answers",
    errors.WORDS_LATE: "steps were not computed in time: the motion paused, no step was lost",
    errors.SETTING_RANGE: "the value is outside the setting's range",
    errors.NO_PROBE: "the board file names no probe",
    errors.COMMANDED_ELSEWHERE: "another link commands the machine: hand the command over first",
    errors.NO_SUCH_LINK: "the board file has no link of this number",
    errors.ZERO_IS_HOMED: "machine zero is where homing found it: it cannot be set elsewhere",
    errors.GARBLED: "bytes that are no whole frame were dropped",
    errors.STOPPED: "dropped: the machine was stopped before its turn came",
    errors.NO_MOTORS: "the motors are the other controller's: connect them to this board first",
    errors.NO_CODE: "neither a pulse code nor a command of the language",
    errors.NUMBER_MISSING: "a number is missing, or unfinished",
    errors.NUMBER_RANGE: "the number is out of its range",
    errors.CUT_OFF: "the file is cut off: fewer or more bytes came than were announced, or none for a while",
    errors.NO_CONTROL: "there is no such control command",
    errors.NO_STEP_PROGRAM: "there is no step program that this could be done with: load one first",
    errors.STEP_PROGRAM_FULL: "the step program is too long to be stored: stream it",
    errors.RETURN_OR_CONTINUE: "moved by hand: return the way back, or continue from here",
    errors.PASSES: "a step program is repeated 1 … 100 times",
    errors.DRIVES_OFF: "the drives have been switched off by hand: switch them on first",
    errors.INTERLOCKED: "the interlock forbids it: the log names the input",
    errors.STEPS_MADE_UP: "an encoder missed steps at the end of a move, and they were made up for: the log says how many",
    errors.POSITION_VERIFIED: "after a halt the encoders have told the position: it is known again",
    errors.SQUARED: "a motor of the gantry was behind, and was stepped alone: the log says which, and by how many steps",
    errors.NO_MEMORY: "no memory is left for arcs: the board file's speeds take it",
    errors.ALARM_LOCKED: "locked: where the machine stands is not known until it is homed",
    errors.ALARM_HARD_LIMIT: "a limit switch or the emergency stop was hit: the position may be lost",
    errors.ALARM_SOFT_LIMIT: "the target lies outside the machine's travel: nothing moved, the position is kept",
    errors.ALARM_RESET: "reset while moving: the position may be lost",
    errors.ALARM_PROBE_STATE: "the probe was not in the state it must begin in",
    errors.ALARM_PROBE_MISSED: "the probe met nothing on its way",
    errors.ALARM_HOMING_RESET: "homing was ended by a reset",
    errors.ALARM_HOMING_DOOR: "homing was ended by the safety door",
    errors.ALARM_SENSOR_STUCK: "homing: a sensor stays active though the head has left it",
    errors.ALARM_SENSOR_DEAD: "homing: a sensor was not found within the travel",
    errors.ALARM_TWO_MOTORS: "homing: the second motor's switch was not found",
    errors.ALARM_INTERLOCK: "the interlock has stopped the machine: the log names the input; the position may be lost",
    errors.ALARM_STEPS_MISSING: "an encoder says that steps are missing, or too many: the log says how many, and where",
    errors.ALARM_GANTRY: "the two motors of the gantry are too far apart: the log names both counts",
}


def text(number):
    """What error or alarm `number` means, in one line."""
    return TEXTS.get(number) or "error %d" % number


def numbers():
    """All numbers of the table, in order."""
    return sorted(TEXTS)
