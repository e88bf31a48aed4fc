"""A machine that speaks the torch's frames, as the page sees it: orders in, one state out. The board has to know Passo's own frames:
they tell state and position.

    machine = TorchMachine(write, tell, board)      # a checked board file: steps/mm, jogs, default speeds

The language does not answer orders. The board counts what it drops and keeps the reason: that is told as soon as it is known. A move
held by a button is a jog that is repeated; when it ends, STOP ends the jog at once, but where axes have ramps: there the board
brakes at the end of what it was asked for, 100 ms or one jog.
"""

import struct

from host_tools.page.cable_machine import CableMachine, NoJob
from passo import errors
from passo.protocols.page.lease import since
from passo.protocols.page.torch import REPEAT_MS, can_of, move_of, preferences, preferences_of, seam_of, straight
from passo.protocols.torch import protocol as torch

_CODES = {"x+": "JOG_X+", "x-": "JOG_X-", "y+": "JOG_Y+", "y-": "JOG_Y-"}


class TorchMachine(CableMachine):
    language = "torch"
    again_ms = 300

    def __init__(self, write, tell, board):
        CableMachine.__init__(self, tell, NoJob(), board)
        self._write = write
        self._cutter = torch.answer_cutter()
        self._ramps = bool(board["planning"]["independent_ramps"])
        axes = board["axes"][:2]
        self._jogs = [axis["jog_steps"] or board["jog"]["steps"] for axis in axes]
        self._speeds = [axis["jog_steps_s"] or board["speed"]["default"] for axis in axes]
        self._steps = None
        self._dropped = None  # as the board has counted
        self._way = None  # the jog that is held
        self._repeated_ms = 0
        self.orders = {"move": self._move, "configure": self._configure, "origin": self._origin, "weave": self._weave, "preferences": self._told}
        self.can = can_of(board)
        self.scale = self.scale[:2]

    # --- bytes

    def feed(self, data, now_ms):
        self._now_ms = now_ms
        self._cutter.put(bytes(data), now_ms)
        while True:
            found = self._cutter.next()
            if found is None:
                return
            if found:
                try:
                    name, fields = torch.answer_from(found)
                except (KeyError, IndexError, ValueError, struct.error):
                    continue
                if name == "PASSO":
                    self._report(fields)

    def _ask(self):
        self._write(torch.passo(torch.STATUS_OF))

    def _go_on(self):
        if self.jog.active and since(self._now_ms, self._repeated_ms) >= REPEAT_MS:
            self._repeated_ms = self._now_ms
            self._write(torch.frame(self._way))

    def _report(self, fields):
        state = self.state
        self._reported()
        name = fields["state"]
        state["state"] = name[:1].upper() + name[1:]
        self._steps = [fields["x"], fields["y"]]
        self._show_place(self._steps)
        state["ours"] = fields["ours"]
        state["dropped"] = fields["dropped"]
        error = fields["error"]
        state["alarm"] = error or state["alarm"] if name == "alarm" else 0
        if error or self._dropped is not None and fields["dropped"] != self._dropped:
            self.note(error or errors.BUSY)
            if self.jog.active:
                self.end_jog()
        self._dropped = fields["dropped"]
        if self.watcher:
            self.watcher(state)

    # --- orders

    def _order(self, data):
        self._write(data)
        return 0

    def stop(self):
        """Stop at once: what was to come is forgotten."""
        self.drop_jog()
        self._write(torch.frame("STOP"))
        return 0

    def unlock(self):
        return self._order(torch.passo(torch.UNLOCK_OF, 1) + torch.passo(torch.UNLOCK_OF, 0))

    def give(self, owner):
        """Take the command from another link; the page gives it to none."""
        return self._order(torch.passo(torch.LINK_OF, 0)) if owner == "page" else errors.UNKNOWN_COMMAND

    def output(self, name, rpm):
        if name not in ("motors_on", "motors_off"):
            return errors.NUMBER
        if name == "motors_off":
            return self.still() or self._order(torch.frame("DISCONNECT"))
        return self.still() or self._order(torch.passo(torch.LINK_OF, 0) + torch.frame("CONNECT"))

    def _straight(self, steps, speed):
        """Go so many steps, straight, at `speed` mm/min."""
        if self.still() or self._steps is None:
            return errors.BUSY
        speeds = straight(steps, self.scale, speed)
        return self._independently(steps, speeds) if speeds else 0

    def _independently(self, steps, speeds):
        signed = [speeds[axis] if steps[axis] >= 0 else -speeds[axis] for axis in range(2)]
        return self._order(torch.move(abs(steps[0]), signed[0], abs(steps[1]), signed[1]))

    def step(self, way, speed):
        """{axis: mm} from here."""
        return self._straight([round(way.get(axis, 0) * self.scale["xy".index(axis)]) for axis in "xy"], speed)

    def go(self, place, speed):
        """{axis: mm}, straight."""
        if self._steps is None:
            return errors.BUSY
        wanted = [round(place[axis] * self.scale["xy".index(axis)]) if axis in place else self._steps["xy".index(axis)] for axis in "xy"]
        return self._straight([wanted[axis] - self._steps[axis] for axis in range(2)], speed)

    def _move(self, order):
        """So many mm of each axis, at a speed of its own in mm/min."""
        steps, speeds = move_of(order, self.scale)
        return self.refusal() or self.still() or self._independently(steps, speeds)

    def _configure(self, order):
        """mm of a jog and default speeds in mm/min, of both axes."""
        jogs, speeds = preferences_of(order, self.scale)
        error = self.refusal() or self.still() or self._order(torch.configure(jogs[0], jogs[1], speeds[0], speeds[1]))
        if not error:
            self._jogs, self._speeds = jogs, speeds
        return error

    def _told(self, order):
        """The preferences as this page knows them."""
        return preferences(self._jogs, self._speeds, self.scale)

    def _origin(self, order):
        return self.refusal() or self.still() or self._order(torch.frame("ORIGIN"))

    def _weave(self, order):
        spec, to, speed, centre = seam_of(order, self.scale)
        seam = torch.weave(spec, to[0], to[1], speed, centre, bool(order.get("clockwise")))
        return self.refusal() or self.still() or self._order(seam)

    # --- the jog

    def _may_jog(self, direction):
        return len([part for part in direction if part]) == 1 and len(direction) == 2 and self._steps is not None

    def _start_jog(self, direction, speed):
        axis = 0 if direction[0] else 1
        self._way = _CODES["xy"[axis] + ("+" if direction[axis] > 0 else "-")]
        self.jog.active = True
        self._repeated_ms = self._now_ms
        self._write(torch.frame(self._way))

    def _brake(self):
        if not self._ramps:
            self._write(torch.frame("STOP"))
