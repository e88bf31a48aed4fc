"""Bytes that grbl takes out of the stream as they come, and what each asks for.

    real_time(0x91).kind        # OVERRIDE: the feed, 10 % more; None for a byte that is none of them
"""

from passo import commands
from passo.commands import Command

_PLAIN = {
    0x18: commands.RESET, 0x21: commands.HOLD, 0x3F: commands.STATUS, 0x7E: commands.RESUME, 0x84: commands.DOOR, 0x85: commands.JOG_CANCEL,
}  # fmt: skip
_TOGGLES = {0x9E: commands.SPINDLE_STOP, 0xA0: 1, 0xA1: 2}
# Per cent, or their change: of the feed from 0x90 on, of rapids from 0x95 on; the first five again of the power from 0x99 on.
_AMOUNTS = (100, 10, -10, 1, -1, 100, 50, 25)


def real_time(byte):
    """The command of a real-time byte, or None."""
    if byte in _PLAIN:
        return Command(_PLAIN[byte])
    if byte in _TOGGLES:
        return Command(commands.TOGGLE, value=_TOGGLES[byte])
    if not 0x90 <= byte <= 0x9D or byte == 0x98:
        return None
    command = Command(commands.OVERRIDE, value=commands.FEED if byte < 0x95 else commands.RAPID if byte < 0x98 else commands.POWER)
    amount = _AMOUNTS[(byte - 0x90) % 9]
    if amount > 10:
        command.power = amount
    else:
        command.feed = amount
    return command
