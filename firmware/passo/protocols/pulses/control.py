"""The control commands of the language of pulse codes: the words between braces, but for those that frame a file.

    parse_control(["jog", "x", "100"], "xyz")   # a Command; BAD where there is no such command
"""

from passo.commands import BAD, CONNECT, HAND_OVER, HOLD, HOME, STATUS, STOP, UNLOCK, Command
from passo.options.step_program.commands import (
    STEPS_CONTINUE, STEPS_GO, STEPS_HAND_DRIVES, STEPS_HAND_TOOL, STEPS_JOG, STEPS_PACE, STEPS_PASSES, STEPS_RETURN, STEPS_STEP, STEP_PROGRAM,
)  # fmt: skip
from passo.options.step_program.errors import PASSES
from passo.protocols.pulses.errors import NO_CONTROL

_PLAIN = {"pause": HOLD, "stop": STOP, "?": STATUS, "home": HOME, "unlock": UNLOCK, "log": STATUS}
_VERBS = {"run": STEPS_GO, "step": STEPS_STEP, "return": STEPS_RETURN, "continue": STEPS_CONTINUE, "repeat": STEPS_PASSES}


def whole_number(text):
    """Return the whole number that `text` is, or -1."""
    return int(text) if text.isdigit() and len(text) < 9 else -1


def parse_control(words, axes):
    """Return the Command of `words`. `axes`: the names of those that a jog may move."""
    verb = words[0] if words else ""
    said = words[1] if len(words) == 2 else ""
    value = whole_number(said)
    command = None
    if verb in _PLAIN and len(words) == 1:
        return Command(_PLAIN[verb], value=1 if verb == "log" else 0)
    if verb in _VERBS:
        command = _verb_command(verb, said, value, len(words) == 1)
    elif verb == "back" and len(words) == 1:
        command = Command(STEP_PROGRAM, None, STEPS_GO, True)
    elif verb == "speed" and value >= 0:
        command = Command(STEP_PROGRAM, None, STEPS_PACE)
        command.feed = value
    elif verb in ("tool", "drives") and said in ("on", "off"):
        command = Command(STEP_PROGRAM, None, STEPS_HAND_TOOL if verb == "tool" else STEPS_HAND_DRIVES, said == "on")
    elif verb == "motors" and said in ("on", "off"):
        command = Command(CONNECT, None, 1 if said == "on" else 0)
    elif verb == "link" and (len(words) == 1 or value > 0):
        command = Command(HAND_OVER, None, max(value, 0))
    elif verb == "jog":
        command = _jog_command(words, axes)
    return command or Command(BAD, error=NO_CONTROL)


def _verb_command(verb, said, value, alone):
    """Return the Command of a verb of _VERBS with one word behind it, or `alone`; None if they do not go together."""
    command = Command(STEP_PROGRAM, None, _VERBS[verb])
    if said == "back" and verb in ("step", "return", "continue"):
        command.tool = True
    elif value >= 0 and verb in ("run", "repeat"):
        command.power = value
        if not value:
            return Command(BAD, error=PASSES)
    elif not alone or verb == "repeat":
        return None
    return command


def _jog_command(words, axes):
    """Return the Command of a jog; None if its words are wrong."""
    target = [0] * len(axes)
    if len(words) < 3 or len(words) % 2 == 0:
        return None
    for index in range(1, len(words), 2):
        axis = axes.find(words[index])
        steps = words[index + 1]
        digits = steps[1:] if steps[0] in "+-" else steps
        if axis < 0 or len(words[index]) != 1 or not digits.isdigit() or len(digits) > 6:
            return None
        target[axis] += int(steps)
    return Command(STEP_PROGRAM, target, STEPS_JOG)
