"""M6 in the way that $341 chooses, and the length of the new tool: for boards that have `tool_change`.

    changer = ToolChange(board)
    pauses = changer.append_change(gcode, made, tool, spindle, rpm, coolant)   # to the list `made`

The ways are grblHAL's, the place of the sensor, for its G59.3, is the board file's:

    0    a pause where the head stands
    1    a pause at the top of Z; ~ probes a touch plate right below; a second pause, to take it away
    2    a pause above the sensor, which ~ probes
    3    a pause at the top of Z above `at`; ~ goes to the sensor and probes it
    4    M6 does nothing

In 1 to 3 spindle and coolant are off meanwhile and come on again at the end, the head back above where it was, at the top. A probe goes
down by $342 at $344 until it touches, and up again at $343 until it does not any more: that edge is the length. The first tool behind
power-up is the reference, work offsets are set with it; of each later one the difference becomes the tool length offset, as G43.1
would set it. ~ does what grblHAL's $TPW does, for senders that have not that word; no jog is possible in a pause.
"""

from micropython import const

from passo import commands, errors
from passo.commands import Command
from passo.protocols.gcode.motion import new_moves
from passo.protocols.gcode.reader import Refused

_MM = 1_000_000  # nm
_AWAY = 1  # of a PROBE: until contact is lost
_WAY = const(341)  # settings: the way, how far down to probe, and the speeds up and down
_DISTANCE = const(342)
_LOCATE = const(343)
_SEEK = const(344)


def extend(protocol, board):
    """Let M6 change tools, in place of a pause."""
    protocol.gcode.changer = ToolChange(board)


class ToolChange:
    def __init__(self, board):
        config = board["tool_change"]
        self._at = [mm * _MM for mm in config["at"]]
        self._sensor = [mm * _MM for mm in config["sensor"]]
        z = board["axes"][2]
        travel = z["travel_steps"] * 1_000_000_000 // z["steps_per_m"]
        self._top = 0 if "z" in board["homing"]["high_end"] else travel
        self._bottom = self._top - travel

    def append_change(self, gcode, made, tool, spindle, rpm, coolant):
        """Append the commands of M6 to `made`. Returns None if spindle and coolant are among them, True if a pause is all, False if M6 does nothing.
        Raises Refused."""
        value = gcode.machine.settings.value
        way = value(_WAY)
        if way == 0 or way == 4:
            return way == 0
        if gcode.commands:
            raise Refused(errors.AXIS_WORDS_UNUSED)
        if not gcode.machine.homed:
            raise Refused(errors.NOT_HOMED)
        here = gcode.position[:2]
        below = here if way == 1 else self._sensor
        top = [self._top]
        down = [max(self._top - value(_DISTANCE) * 1000, self._bottom)]
        gcode._set_shared(0, 0, 0, 0, 5, 0)
        made += [Command(commands.SPINDLE, value=5), Command(commands.COOLANT)]
        made += self._go_by(gcode, here + top)
        if way != 1:
            made += self._go_by(gcode, (self._at if way == 3 else below) + top)
        made.append(Command(commands.PAUSE, value=1 + tool))
        if way == 3:
            made += self._go_by(gcode, below + top)
        made += self._go_by(gcode, below + down, commands.PROBE, value(_SEEK) * 1000 // 60)
        made += self._go_by(gcode, below + top, commands.PROBE, value(_LOCATE) * 1000 // 60)
        made[-1].value = _AWAY
        made[-1].measures = True
        made += self._go_by(gcode, below + top)
        if way == 1:
            made.append(Command(commands.PAUSE))
        else:
            made += self._go_by(gcode, here + top)
        if coolant:
            made.append(Command(commands.COOLANT, value=coolant))
        if spindle != 5:
            made.append(gcode._spindle_command(spindle, rpm, 0))
        gcode.commands = []  # _add_motion() has put the motions there
        gcode._moves = new_moves()
        gcode.position = here + top
        gcode._steps = list(gcode._to_steps(gcode.position))

    def _go_by(self, gcode, target, kind=commands.LINE, feed=0):
        """Return [the motion to `target`, nm], a line or a probe at `feed` nm/s (0: rapid)."""
        command = gcode._go_to(kind, target, feed)
        command.value = 0
        return [command]
