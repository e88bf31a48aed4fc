"""The page of a machine that draws objects of points: keys jog it, a position is an object of one point, pen up; a held jog ends with STOP.

    machine = PlotterPage(record, number, board, tell, language)
"""

from micropython import const

from passo import commands, errors
from passo.commands import Command
from passo.protocols.page.page_machine import PageMachine
from passo.protocols.page.orders import number_field

MOST_PLACE = const(65535)  # steps, as the language of packets has it


def jogs_of(board):
    """{direction: name} of the four jogs, (x, y) of -1, 0, 1; the board file's jog.up says where UP goes."""
    up = board["jog"]["up"]
    sign = 1 if up[1] == "+" else -1
    x, y = (0, sign) if up[0] == "y" else (sign, 0)
    return {(x, y): "UP", (-x, -y): "DOWN", (y, -x): "RIGHT", (-y, x): "LEFT"}


def signs_of(direction):
    """The direction of a jog as a tuple of -1, 0 and 1."""
    return tuple([1 if part > 0 else -1 if part < 0 else 0 for part in direction])


class PlotterPage(PageMachine):
    language = "plotter"
    # Damaged bytes of a cable may look like another command: no packet of the sender was refused.
    untold = (errors.STOPPED, errors.CHECKSUM, errors.BYTES_DROPPED, errors.WORDS_LATE, errors.UNKNOWN_COMMAND)
    can = ("place", "jog", "step", "goto", "home", "log", "points")

    def __init__(self, record, number, board, tell, language):
        PageMachine.__init__(self, record, number, board, tell)
        self._jogs = jogs_of(board)
        self._take_travel()
        self._steps = None
        self._way = None
        self.orders = {"pace": self._set_pace}

    def _take_travel(self):
        self._travel = [min(axis["travel_steps"], MOST_PLACE) for axis in self._board["axes"]]

    def _follow_settings(self, settings):
        PageMachine._follow_settings(self, settings)
        self._take_travel()

    def _show_fields(self, report):
        """Show position and feed, points drawn, free points, and the pen, which is up unless another link draws."""
        self._steps = list(report["position"][:2])
        self._show_position(self._steps)
        state = self.state
        state["drawn"], state["free"] = report["drawn"], report["free"]
        if report["state"] != "hold":
            state["pen"] = "up" if report["state"] != "run" or self.unanswered else ""  # another link draws
        self._tell_error(report)

    # --- orders

    hold = resume = unlock = PageMachine._refuse_order

    def _set_pace(self, order):
        """Set the drawing speed, in the unit of the board file. Returns 0 or an error. Raises Wrong."""
        return self.refusal() or self.busy_error() or self.queue_command(Command(commands.SPEED, value=int(number_field(order, "speed", 1, MOST_PLACE))))

    def _move_pen(self, wanted):
        """Go to a position in steps, pen up: an object of one point."""
        error = self.busy_error()
        if error:
            return error
        if [axis for axis in range(2) if not 0 <= wanted[axis] <= self._travel[axis]]:
            return errors.JOG_TRAVEL
        self.queue_command(Command(commands.POINT, tuple(wanted)))
        return self.queue_command(Command(commands.DRAW))

    def step_by(self, way, speed):
        """Move by `way`, {axis: mm}, pen up; `speed` is the drawing's own. Returns 0 or an error."""
        if self._steps is None:
            return errors.BUSY
        return self._move_pen([at + by for at, by in zip(self._steps, self._steps_by(way))])

    def go_to(self, position, speed):
        """Move to `position`, {axis: mm}, pen up; `speed` is the drawing's own. Returns 0 or an error."""
        if self._steps is None:
            return errors.BUSY
        return self._move_pen(self._steps_to(position, self._steps))

    # --- the jog

    def _may_jog(self, direction):
        """True if a key jogs in this direction, the position is known and no command is under way."""
        return signs_of(direction) in self._jogs and self._steps is not None and not self.unanswered

    def _start_jog(self, direction, speed):
        self._way = signs_of(direction)
        self.jog.active = True
        self._repeat_jog(0)

    def _repeat_jog(self, error):
        """Queue the next jog behind the answer to the last one, as long as the button is held. `error`: of the answer; 0: accepted."""
        if not self.jog.active:
            return
        if error:
            self.drop_jog()
            self.note_result(error)
        else:
            self.queue_command(Command(commands.JOG, self._way), self._repeat_jog)

    def _brake(self):
        self.said = []
        self.queue_command(Command(commands.STOP))
