"""`$ENC`: what encoders have counted, and `$ENC=0`, which counts from here on."""

from passo import errors
from passo.commands import HELLO, ZERO_COUNTS, Command


def extend(protocol, board):
    protocol.system.learn("$ENC", understand, True)


def understand(machine, text):
    if text:
        return [Command(ZERO_COUNTS)] if text == "=0" else errors.STATEMENT
    return tell(machine.port.encoders)


def tell(encoders):
    """A line an encoder: motor, counts, steps turned beyond those stepped, the largest such error so far."""
    command = Command(HELLO)
    rows = [(name, encoders.count(number), encoders.steps(number), encoders.most(number)) for number, name in enumerate(encoders.names)]
    command.text = "".join(["[ENC:%s,%d,%d,%d]\r\n" % row for row in rows])
    return [command]
