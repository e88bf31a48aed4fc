"""The commands of this option, by number, behind those of passo/commands.py."""

from micropython import const

ZERO_COUNTS = const(34)  # the counts of the encoders that are shown begin at 0
