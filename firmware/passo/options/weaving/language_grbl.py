"""`$WEAVE=`: which way the lines and arcs of a link that speaks grbl are woven."""

from passo import errors
from passo.commands import Command
from passo.options.weaving.commands import WEAVE
from passo.protocols.gcode.words import X


def extend(protocol, board):
    """Add `$WEAVE=` to a link's protocol."""
    protocol.system.learn_lines("$WEAVE=", lambda machine, text: weave_commands(protocol.gcode.words, text))


def weave_commands(words, text):
    """Return the command of SHAPE,AMPLITUDE,PITCH[,LEFT,RIGHT[,ALONG]] (docs/use/weaving.md) or of 0, off; or the number of an error. `words`: the
    parser's."""
    if text == "0":
        return [Command(WEAVE, value=None)]
    parts = (text + ",0,0,0").split(",")[:6]
    spec = []
    for part, places in zip(parts, (0, 3, 3, 3, 3, 0)):  # mm, seconds
        error = words.scan_line(b"X" + part.encode())
        if error or words.count or words.have != 1 << X:
            return errors.NUMBER
        spec.append(words.word_value(X, places))
    return [Command(WEAVE, value=tuple(spec))]
