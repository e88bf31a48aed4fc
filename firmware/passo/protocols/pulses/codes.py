"""The codes of a pulse file. A file is text; blanks and line ends between codes are ignored, anything not named here is an error:

    A … Z     one step of each of a code's axes, see CODES
    [ ]       drives on, off              ( )   tool on, off
    *5000     wait 5000 ms                +2000 speed 2000 mm/min (+0: the operator sets one)
    $ @       the fastest speed, the board file's
"""

from passo.options.step_program.commands import STEPS_DEFAULT, STEPS_DRIVES, STEPS_FASTEST, STEPS_TOOL

WAIT_MS = (0, 3_600_000)
SPEED_MM_MIN = (0, 900_000)

# The steps of each letter, from A on: bits 0 to 2 the axes x, y, z, bits 4 to 6 those of them that go backward.
CODES = bytes((
    0x01, 0x11, 0x02, 0x22, 0x04, 0x44,  # A X+, B X−, C Y+, D Y−, E Z+, F Z−
    0x03, 0x23, 0x13, 0x33,  # G X+Y+, H X+Y−, I X−Y+, J X−Y−
    0x05, 0x45, 0x15, 0x55,  # K X+Z+, L X+Z−, M X−Z+, N X−Z−
    0x06, 0x46, 0x26, 0x66,  # O Y+Z+, P Y+Z−, Q Y−Z+, R Y−Z−
    0x07, 0x47, 0x27, 0x67,  # S X+Y+Z+, T X+Y+Z−, U X+Y−Z+, V X+Y−Z−
    0x17, 0x57, 0x37, 0x77,  # W X−Y+Z+, X X−Y+Z−, Y X−Y−Z+, Z X−Y−Z−
))  # fmt: skip
MARKS = {
    0x5B: 1 << 8 | STEPS_DRIVES << 4,  # [
    0x5D: STEPS_DRIVES << 4,  # ]
    0x28: 1 << 8 | STEPS_TOOL << 4,  # (
    0x29: STEPS_TOOL << 4,  # )
    0x24: STEPS_FASTEST << 4,  # $
    0x40: STEPS_DEFAULT << 4,  # @
}
