"""M6 at a position of its own, and the length of the new tool: for boards that have `tool_change`.

    changer = ToolChange(board)
    changer.append(gcode, tool, spindle, rpm, coolant)      # to gcode.commands

Spindle and coolant go off, Z to its top, the head to `at`; there the machine waits for `~`. Then it goes to `sensor`, down
until the sensor answers, and up again, slowly, until it does not any more: that edge is the length. The first tool behind power-up
is the reference, work offsets are set with it; of each later one the difference becomes the tool length offset, as G43.1
would set it. At last the head goes back above where it was, at the top, and spindle and coolant come on again.
As grblHAL's mode 3 ($341=3), but that the places come from the board file.
"""

from passo import commands, errors
from passo.commands import Command
from passo.protocols.gcode.motion import new_moves
from passo.protocols.gcode.reader import Refused

_MM = 1_000_000  # nm
_AWAY = 1  # of a PROBE: until contact is lost


class ToolChange:
    def __init__(self, board):
        config = board["tool_change"]
        self._at = [mm * _MM for mm in config["at"]]
        self._sensor = [mm * _MM for mm in config["sensor"]]
        self._down = config["distance_mm"] * _MM
        self._seek = config["seek_mm_min"] * _MM // 60
        self._locate = config["locate_mm_min"] * _MM // 60
        z = board["axes"][2]
        self._top = 0 if "z" in board["homing"]["high_end"] else z["travel_steps"] * 1_000_000_000 // z["steps_per_m"]

    def append(self, gcode, tool, spindle, rpm, coolant):
        """Raises Refused."""
        if gcode.commands:
            raise Refused(errors.AXIS_WORDS_UNUSED)
        if not gcode.machine.homed:
            raise Refused(errors.NOT_HOMED)
        here = gcode.position[:2]
        top = self._top
        gcode._prepare(0, 0, 0, 0, 5, 0)
        made = [Command(commands.SPINDLE, value=5), Command(commands.COOLANT)]
        made += self._go(gcode, here + [top])
        made += self._go(gcode, self._at + [top])
        made.append(Command(commands.PAUSE, value=1 + tool))
        made += self._go(gcode, self._sensor + [top])
        made += self._go(gcode, self._sensor + [top - self._down], commands.PROBE, self._seek)
        made += self._go(gcode, self._sensor + [top], commands.PROBE, self._locate)
        made[-1].value = _AWAY
        made[-1].measures = True
        made += self._go(gcode, self._sensor + [top])
        made += self._go(gcode, here + [top])
        if coolant:
            made.append(Command(commands.COOLANT, value=coolant))
        if spindle != 5:
            made.append(gcode._spindle_command(spindle, rpm, 0))
        gcode.commands = made
        gcode._moves = new_moves()
        gcode.position = here + [top]
        gcode._steps = list(gcode._to_steps(gcode.position))

    def _go(self, gcode, target, kind=commands.LINE, feed=0):
        """[a motion]."""
        command = gcode._move(kind, target, feed)
        command.value = 0
        gcode.position = target
        gcode._steps = command.target
        return [command]
