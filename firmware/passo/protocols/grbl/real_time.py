"""Bytes that grbl takes out of the stream as they come, and what each asks for.

    real_time(0x91).kind        # OVERRIDE: the feed, 10 % more; None for a byte that is none of them
"""

from micropython import const

from passo import commands
from passo.commands import Command

# Kind · 1, value · 64, whether the amount is a change · 512, amount · 1024: in one integer, 20 tuples take much more.
_VALUE = const(6)
_CHANGE = const(9)
_AMOUNT = const(10)
_REAL_TIME = {
    0x18: commands.RESET,
    0x21: commands.HOLD,
    0x3F: commands.STATUS,
    0x7E: commands.RESUME,
    0x84: commands.DOOR,
    0x85: commands.JOG_CANCEL,
    0x9E: commands.TOGGLE | commands.SPINDLE_STOP << _VALUE,
    0xA0: commands.TOGGLE | 1 << _VALUE,
    0xA1: commands.TOGGLE | 2 << _VALUE,
    0x95: commands.OVERRIDE | commands.RAPID << _VALUE | 100 << _AMOUNT,
    0x96: commands.OVERRIDE | commands.RAPID << _VALUE | 50 << _AMOUNT,
    0x97: commands.OVERRIDE | commands.RAPID << _VALUE | 25 << _AMOUNT,
}


def _add(first, override):
    """The five bytes of an override: 100 %, and its changes."""
    _REAL_TIME[first] = override | 100 << _AMOUNT
    for byte, change in ((1, 10), (2, -10), (3, 1), (4, -1)):
        _REAL_TIME[first + byte] = override | 1 << _CHANGE | change << _AMOUNT


_add(0x90, commands.OVERRIDE | commands.FEED << _VALUE)
_add(0x99, commands.OVERRIDE | commands.POWER << _VALUE)


def real_time(byte):
    """The command of a real-time byte, or None."""
    found = _REAL_TIME.get(byte)
    if found is None:
        return None
    command = Command(found & 63, None, found >> _VALUE & 7)
    if found >> _CHANGE & 1:
        command.feed = found >> _AMOUNT
    else:
        command.power = found >> _AMOUNT
    return command
