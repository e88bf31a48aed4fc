"""Pauses of a machine that parks: while the door holds it, an axis goes up before anything else, and comes back to the path.

    door      stand on the path, spindle on     up by $56 at $57     spindle and coolant off     up to $58 at $59
    `~`       down at $59 to where $56 had led  spindle and coolant on, until they are there     down to the path at $57     on

If the door opens again in between, the axis goes up again. As grbl with parking and grblHAL: only if $41 is set, the machine is homed, no
laser ($32), and the axis stands below the target. Not while a probe is under way.
"""

from micropython import const

from passo import commands
from passo.control import pauses
from passo.control.feature import QUEUE_GONE
from passo.options.parking.config import AXIS, HEIGHT, ON, PULL_OUT, PULL_OUT_SPEED, SPEED
from passo.options.parking.steps import Detour
from passo.records import ROW_TAG

# The kinds of the line under way:
_PULLS = const(1)
_RISES = const(2)
_RETURNS = const(3)
_PLUNGES = const(4)


class Pauses(pauses.Pauses):
    event_mask = QUEUE_GONE

    def __init__(self, board, machine, queue):
        pauses.Pauses.__init__(self, board, machine, queue)
        self._detour = Detour(*queue.lend())
        self._way = 0
        self._path = self._pulled = 0  # the axis's position as it left the path, and as it was pulled out; while the machine is away
        self._power = 0  # of the tool, there

    def on_events(self, _=QUEUE_GONE):
        """Forget the way back, because the queue has dropped the block that the axis left."""
        self._detour.forget_line()
        self._way = 0
        self._machine.away = False

    halt = on_events

    def poll_hold(self):
        """Go on with the way up or back; at its end with the base."""
        if not self._way or self._hands_back():
            pauses.Pauses.poll_hold(self)

    def _hands_back(self):
        """Return True if the base decides again: all is to be dropped, or a hold has stopped the line. Else go on to the next line once this one is
        done."""
        machine = self._machine
        if machine.dropping:
            return True
        way = self._way
        done = self._detour.is_done()
        if not done and not self._queue.standing():
            return False
        self._detour.end()
        self._way = 0
        if done and way == _PULLS:
            self._rise_to_target()
        elif done and way == _RISES:
            pauses.Pauses._begin_stand(self)
        elif done and machine.resuming:
            if way == _RETURNS:
                self._queue.analogue.set(self._power)
                pauses.Pauses._switch_on(self)
            else:
                machine.away = False
                pauses.Pauses._go_on(self)
        else:
            return True
        return False

    # --- up

    def _has_to_park(self):
        """Return True if the door holds the machine, and the axis has to go up from here."""
        machine = self._machine
        value = machine.settings.value
        if machine.hold != "door" or not value(ON) or not machine.homed or self._is_laser() or machine.busy_with(commands.PROBE):
            return False
        return self._axis_position() < self._steps_of(value(HEIGHT))

    def _axis_position(self):
        """Return the position of the axis that parks, in steps."""
        return self._queue.position()[self._machine.settings.value(AXIS)]

    def _steps_of(self, um):
        """Return the steps of a machine coordinate of the axis, in µm, within its travel."""
        axis = self._machine.settings.value(AXIS)
        low, high = self._queue.reach(axis)
        return min(max(um * self._machine.steps_per_m[axis] // 1_000_000, low), high)

    def _begin_stand(self):
        """At the stand of a hold: pull the axis out if it parks, else see the base."""
        if not self._has_to_park():
            pauses.Pauses._begin_stand(self)
            return
        machine = self._machine
        lit = self._queue.lit()
        self._was_lit = self._was_lit or lit
        here = self._axis_position()
        value = machine.settings.value
        if not machine.away:
            machine.away = True
            self._path = here
            self._power = self._queue.analogue.value
            out = value(PULL_OUT) * machine.steps_per_m[value(AXIS)] // 1_000_000
            self._pulled = min(here + out, self._steps_of(value(HEIGHT)))
        if here < self._pulled:
            self._set_out(_PULLS, self._pulled, PULL_OUT_SPEED, lit)
        else:
            self._rise_to_target()

    def _rise_to_target(self):
        """Switch spindle and coolant off, and go up to the target."""
        self._queue.rest(False)
        self._machine.show_outputs(False)
        self._set_out(_RISES, self._steps_of(self._machine.settings.value(HEIGHT)), SPEED, False)

    # --- and back

    def _switch_on(self):
        """Go down to where the axis was pulled out to, then switch on; see the base."""
        if self._machine.away:
            self._set_out(_RETURNS, self._pulled, SPEED, False)
        else:
            pauses.Pauses._switch_on(self)

    def _go_on(self):
        """Plunge to the path, then go on; see the base."""
        if self._machine.away:
            self._set_out(_PLUNGES, self._path, PULL_OUT_SPEED, self._queue.lit())
        else:
            pauses.Pauses._go_on(self)

    def _set_out(self, way, goal, speed, tool):
        """Begin a line to `goal`, a position of the axis in steps; `speed`: the number of the setting with its speed."""
        machine = self._machine
        queue = self._queue
        axis = machine.settings.value(AXIS)
        deltas = [0] * len(machine.steps_per_m)
        deltas[axis] = goal - self._axis_position()
        self._way = way
        at = queue.planner.row()
        tag = queue.planner.rows[at + ROW_TAG] if at >= 0 else 0
        power = self._power if tool or not self._spindle["pwm"] else 0
        self._detour.begin(deltas, machine.settings.value(speed) * 50 // 3, tool, power, tag)
