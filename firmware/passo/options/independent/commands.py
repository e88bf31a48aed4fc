"""The commands of this option, by number, behind those of passo/commands.py."""

from micropython import const

from passo.commands import RUN, Command

REST = const(30)  # the axes of the mask `value` come to a stand, the others run on; see Rest
ZERO = const(31)  # machine zero is here; only at a stand, and where homing has not found it

AT_REST = const(0)  # Run.when: refused while anything moves
AS_JOG = const(1)  # or extends a jog of the same axes in the same directions
LIVE = const(2)  # or changes what the axes named do, while others run on
FOREVER = const(0x1FFFFFFF)  # steps of a Run without an end


class Run(Command):
    """RUN. `steps` of each axis, signed, ±FOREVER, 0 to change its rate only, None to leave it alone; `rates` of each: (steps, in
    milliseconds). `when` it may be: AT_REST, AS_JOG or LIVE. Of a live one the steps are added to those to come, or take their place where
    the direction is the other one. FINISHED follows when all axes stand.
    """

    unpowered = 0  # mask of axes that have no current once they stand, until the next such command

    def __init__(self, steps, rates, when=AT_REST):
        Command.__init__(self, RUN)
        self.steps = steps
        self.rates = rates
        self.when = when


class Rest(Command):
    """REST of the axes of the mask `axes`."""

    unpowered = 0  # as of a Run

    def __init__(self, axes):
        Command.__init__(self, REST, value=axes)
