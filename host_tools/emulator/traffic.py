"""Packets of the plotter's language for a wire that is never quiet.

In it a byte that repeats its neighbour makes the board wait for a pause (see protocols/plotter/protocol.py); a host that does
not pause must avoid that, as real drawings do for the most part.
"""


def move_packets(count, seed=0):
    """Return the bytes of `count` MOVE packets in which no byte repeats its neighbour."""
    from passo.protocols.plotter.host import COMMANDS, packet

    data, number = b"", seed
    while count:
        number += 1
        one = packet(COMMANDS["MOVE"], 0x1234 + 7 * number & 0x7FFF, 0x2301 + 11 * number & 0x7FFF)
        both = data[-1:] + one + one[:1]  # another MOVE follows
        if all(a != b for a, b in zip(both, both[1:])):
            data += one
            count -= 1
    return data
