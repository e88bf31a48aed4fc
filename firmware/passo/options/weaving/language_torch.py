"""A seam in the torch's language: the frame `66 shape along way`, and nine integers.

    weave(spec, x, y, speed_um_s)       # its bytes, for a host

The integers: amplitude and pitch in µm, ms at the left and at the right edge, steps to the end and to the centre of x and y, µm/s.
"""

import struct

from micropython import const

from passo import errors
from passo.commands import BAD, Command, Motion
from passo.options.weaving.commands import SEAM
from passo.protocols.torch.frames import END
from passo.protocols.torch.protocol import integers
from passo.records import FARTHEST

_CODE = const(0x66)


def extend(protocol, board):
    """Add the frame to a link's protocol."""
    protocol.learn_frame(_CODE, seam_command)


def weave(spec, x, y, speed_um_s, centre=(0, 0), clockwise=False):
    """Return the frame of a seam to (x, y) steps from here, woven by a spec of motion.py, at `speed_um_s`; about `centre`, steps from here, if
    that is not 0;0."""
    shape, amplitude, pitch, left, right, along = spec
    head = bytes((_CODE, shape, along, 1 if clockwise else 0))
    return head + integers(amplitude, pitch, left, right, x, y, centre[0], centre[1], speed_um_s) + bytes((END,))


def seam_command(data):
    """Return the Command of a frame."""
    amplitude, pitch, left, right, x, y, to_x, to_y, speed = struct.unpack_from(">IIIIiiiiI", data, 4)
    if max(abs(x), abs(y), abs(to_x), abs(to_y)) >= FARTHEST or not 0 < speed < 1_000_000:
        return Command(BAD, error=errors.TRAVEL)
    command = Motion(SEAM, [x, y])
    command.value = data[1], amplitude, pitch, left, right, data[2]
    command.clockwise = data[3] == 1
    command.centre = to_x, to_y
    command.over_half = x == 0 and y == 0
    command.feed = speed * 1000
    return command
