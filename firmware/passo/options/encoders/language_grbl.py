"""`$ENC`: the encoders' counts, and `$ENC=0`, which counts from here on."""

from passo import errors
from passo.commands import HELLO, Command
from passo.options.encoders.commands import ZERO_COUNTS


def extend(protocol, board):
    """Add `$ENC` and `$ENC=` to the language."""
    protocol.system.learn_lines("$ENC=", count_anew)
    protocol.system.learn_lines("$ENC", counts_report, True)


def count_anew(machine, text):
    """Return the command of `$ENC=0`, or the number of an error."""
    return [Command(ZERO_COUNTS)] if text == "0" else errors.STATEMENT


def counts_report(machine, text):
    """Return the answer to `$ENC`, a line an encoder: motor, counts, steps turned beyond those stepped, the largest such error so far."""
    if text:
        return errors.STATEMENT
    command = Command(HELLO)
    encoders = machine.port.encoders
    rows = [(name, encoders.count_of(number), encoders.steps_beyond(number), encoders.largest_error(number)) for number, name in enumerate(encoders.names)]
    command.text = "".join(["[ENC:%s,%d,%d,%d]\r\n" % row for row in rows])
    return [command]
