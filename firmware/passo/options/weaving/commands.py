"""The commands of this option, by number, behind those of passo/commands.py."""

from micropython import const

WEAVE = const(37)  # `value`: how lines and arcs at a feed are woven from now on, a spec of motion.py; None: not at all
SEAM = const(38)  # a line or an arc woven by `value`, from rest: `target` in steps from here; the rest as of a Motion
