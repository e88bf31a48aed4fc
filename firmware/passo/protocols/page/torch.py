"""The page of a torch, whose axes run on their own: straight positions, moves with a speed of each axis, preferences of jogs.

    machine = TorchPage(record, number, board, tell, language)

A move held by a button is a jog that is repeated; when it ends, STOP ends the jog at once; if axes have ramps, the board brakes at the end
of the steps asked for, 100 ms or one jog.
"""

from micropython import const

from passo import commands, errors
from passo.commands import STILL, Command
from passo.options.independent.commands import AS_JOG, AT_REST, FOREVER, ZERO, Run
from passo.protocols.page.lease import ms_since
from passo.protocols.page.orders import Wrong, number_field, positions_field
from passo.protocols.page.page_machine import PageMachine

REPEAT_MS = const(40)  # between two jogs of one that is held
_MOST_JOG_MM = 100.0
_MOST_SCALE = 100_000.0
_X_SCALE = const(100)  # steps/mm of x, of the settings


def can_of(board):
    """The orders of a board's page, a tuple."""
    words = ["place", "jog", "step", "goto", "jog_speed", "unlock", "log", "origin"]
    if [output for output in board["outputs"] if output["role"] == "ours"]:
        words.append("motors")
    return tuple(words)


def straight_speeds(steps, scale, speed):
    """The steps/s of both axes at which they go `steps` along a straight line at `speed` mm/min; None: both have no steps."""
    way = [steps[axis] / scale[axis] for axis in range(2)]
    length = sum([part * part for part in way]) ** 0.5
    return [max(1, round(abs(steps[axis]) * speed / 60 / length)) for axis in range(2)] if length else None


def _speed_of(order, name, scale):
    """The speed in field `name` of an order, mm/min, as steps/s. `scale`: steps/mm. Raises Wrong."""
    return max(1, round(number_field(order, name, 0.1, 50_000) * scale / 60))


def move_of(order, scale):
    """(steps, steps/s) of both axes, of an order to move by mm with a speed of each axis in mm/min. Raises Wrong."""
    by = positions_field(order, "by", "xy")
    return [round(by.get("xy"[axis], 0) * scale[axis]) for axis in range(2)], [_speed_of(order, "xy"[axis] + "v", scale[axis]) for axis in range(2)]


def preferences_of(order, scale):
    """(steps of a jog, default steps/s) of both axes, of an order with mm and mm/min. Raises Wrong."""
    jogs = [round(number_field(order, "jog" + "xy"[axis], 0.001, _MOST_JOG_MM) * scale[axis]) for axis in range(2)]
    speeds = [_speed_of(order, "xy"[axis] + "v", scale[axis]) for axis in range(2)]
    if [jog for jog in jogs if not jog]:
        raise Wrong("jogx")
    return jogs, speeds


def preferences_message(jogs, speeds, scale):
    """The message with the preferences for a page: jogs in mm, speeds in mm/min. `jogs`: steps, `speeds`: steps/s, `scale`: steps/mm."""
    return {
        "t": "preferences", "do": "preferences", "error": 0, "scale": scale[:2],
        "jog": [round(jogs[axis] / scale[axis], 3) for axis in range(2)],
        "speed": [round(speeds[axis] * 60 / scale[axis], 1) for axis in range(2)],
    }  # fmt: skip


class TorchPage(PageMachine):
    language = "torch"

    def __init__(self, record, number, board, tell, language):
        self.can = can_of(board)
        PageMachine.__init__(self, record, number, board, tell)
        self._ramps = bool(board["planning"]["independent_ramps"])
        axes = board["axes"][:2]
        self._jogs = [axis["jog_steps"] or board["jog"]["steps"] for axis in axes]
        self._speeds = [axis["jog_steps_s"] or board["speed"]["default"] for axis in axes]
        if record.settings:
            self._take_jogs(record.settings)
        self._steps = None
        self._way = None  # the jog that is held: axis and sign
        self._repeated_ms = 0
        self._dropped = 0
        self.orders = {"move": self._order_move, "configure": self._set_preferences, "origin": self._set_origin, "preferences": self._tell_preferences}
        self.scale = self.scale[:2]

    def _take_jogs(self, settings):
        self._jogs = [settings.jog_steps(axis) for axis in range(2)]
        self._speeds = [settings.jog_steps_s(axis) for axis in range(2)]

    def _follow_settings(self, settings):
        PageMachine._follow_settings(self, settings)
        self._take_jogs(settings)

    def _show_fields(self, report):
        self._steps = list(report["position"][:2])
        self._show_position(self._steps)
        self.state["ours"] = report["ours"]
        self.state["dropped"] = self._dropped
        self._tell_error(report)

    def note_result(self, error):
        """Note the result of a command; count one that was refused."""
        if error:
            self._dropped += 1
        PageMachine.note_result(self, error)

    # --- orders

    hold = resume = home = PageMachine._refuse_order

    def unlock(self):
        return self._queue_pair(Command(commands.RESET), Command(commands.UNLOCK))

    def set_output(self, name, rpm):
        """Switch the motors: "motors_on" or "motors_off". Returns 0 or an error."""
        if name not in ("motors_on", "motors_off"):
            return errors.NUMBER
        error = self.busy_error()
        if error:
            return error
        if name == "motors_off":
            return self.queue_command(Command(commands.CONNECT, value=0))
        return self._queue_pair(Command(commands.HAND_OVER), Command(commands.CONNECT, value=1))

    def _run_axes(self, steps, speeds, when, answered=None):
        """Queue a motion of `steps` at steps/s `speeds` of each axis; `when`: AT_REST or AS_JOG. Returns 0 or an error."""
        error = 0 if max([abs(part) for part in steps]) < FOREVER else errors.TRAVEL
        return error or self.queue_command(Run([part or None for part in steps], [(speed, 1000) for speed in speeds], when), answered)

    def _run_straight(self, steps, speed):
        if self.busy_error() or self._steps is None:
            return errors.BUSY
        speeds = straight_speeds(steps, self.scale, speed)
        return self._run_axes(steps, speeds, AT_REST) if speeds else 0

    def step_by(self, way, speed):
        """Move straight by `way`, {axis: mm}, at `speed` mm/min. Returns 0 or an error."""
        return self._run_straight(self._steps_by(way), speed)

    def go_to(self, position, speed):
        """Move straight to `position`, {axis: mm}, at `speed` mm/min. Returns 0 or an error."""
        if self._steps is None:
            return errors.BUSY
        wanted = [round(position.get("xy"[axis], self.position[axis]) * self.scale[axis]) for axis in range(2)]
        return self._run_straight([wanted[axis] - self._steps[axis] for axis in range(2)], speed)

    def _order_move(self, order):
        steps, speeds = move_of(order, self.scale)
        return self.refusal() or self.busy_error() or self._run_axes(steps, speeds, AT_REST)

    def _set_preferences(self, order):
        """Set steps/mm, jogs (mm) and default speeds (mm/min) of both axes. Returns 0 or an error. Raises Wrong."""
        scale = [number_field(order, "s" + "xy"[axis], 0.001, _MOST_SCALE, self.scale[axis]) for axis in range(2)]
        found = preferences_of(order, scale)
        error = self.refusal() or self.busy_error()
        if error:
            return error
        said = [Command(commands.SETTING, _X_SCALE + axis, round(1000 * scale[axis])) for axis in range(2) if scale[axis] != self.scale[axis]]
        self._send_preferences(said + [Command(STILL, value=found)], scale, found)
        return 0

    def _send_preferences(self, said, scale, found):
        """Queue the commands one by one, as long as none is refused; then keep scale and preferences."""

        def take_answer(error):
            """Send the next preference, or take all over once the last is set; note an error and end."""
            if error:
                self.note_result(error)
            elif said[1:]:
                self._send_preferences(said[1:], scale, found)
            else:
                self.scale = scale
                self._jogs, self._speeds = found

        self.queue_command(said[0], take_answer)

    def _tell_preferences(self, order):
        """Return the message with the preferences that this page knows."""
        return preferences_message(self._jogs, self._speeds, self.scale)

    def _set_origin(self, order):
        return self.refusal() or self.busy_error() or self.queue_command(Command(ZERO))

    # --- the jog

    def _may_jog(self, direction):
        """True if the direction is one axis, and the position is known."""
        return len([part for part in direction if part]) == 1 and len(direction) == 2 and self._steps is not None

    def _start_jog(self, direction, speed):
        """Begin to repeat jogs of the axis; `speed` is the preferences'."""
        axis = 0 if direction[0] else 1
        self._way = axis, 1 if direction[axis] > 0 else -1
        self.jog.active = True
        self._repeat_jog()

    def _repeat_jog(self):
        axis, sign = self._way
        self._repeated_ms = self._now_ms
        steps = [0, 0]
        steps[axis] = sign * self._jogs[axis]
        self._run_axes(steps, self._speeds, AS_JOG, self._take_jog_answer)

    def _take_jog_answer(self, error):
        if error:
            self.note_result(error)
            self.end_jog()

    def update_jog(self, now_ms):
        """End a jog whose lease has lapsed; repeat one that is held each REPEAT_MS."""
        PageMachine.update_jog(self, now_ms)
        if self.jog.active and ms_since(now_ms, self._repeated_ms) >= REPEAT_MS:
            self._repeat_jog()

    def _brake(self):
        if not self._ramps:
            self.queue_command(Command(commands.STOP))
