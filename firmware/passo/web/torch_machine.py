"""A machine that speaks the torch's frames, as the page sees it: orders in, one state out. The board has to know Passo's own frames:
they tell state and position.

    machine = TorchMachine(write, tell, board)      # a checked board file: steps/mm, jogs, default speeds

The language does not answer orders. The board counts what it drops and keeps the reason: that is told as soon as it is known. A move
held by a button is a jog that is repeated; when it ends, STOP ends the jog at once, but where axes have ramps: there the board
brakes at the end of what it was asked for, 100 ms or one jog.
"""

import struct

from micropython import const

from passo import errors
from passo.protocols.torch import protocol as torch
from passo.web.any_machine import AnyMachine
from passo.web.api import Wrong, number, places, text
from passo.web.lease import since

_REPEAT_MS = const(40)  # between two frames of a jog that is held
_MOST_JOG_MM = 100.0
_MOST_UM_S = const(1_000_000)
_SHAPES = ("zigzag", "triangle", "trapezoid", "sine")  # from 1 on
_CODES = {"x+": "JOG_X+", "x-": "JOG_X-", "y+": "JOG_Y+", "y-": "JOG_Y-"}


class NoJob:
    """The language knows no files."""

    name = ""

    def running(self):
        return False

    def poll(self):
        pass

    def refresh(self):
        pass

    def fail(self, error):
        pass

    def abort(self):
        return 0

    def run(self, name, lines, passes, checked, single=False):
        return errors.UNKNOWN_COMMAND


class TorchMachine(AnyMachine):
    language = "torch"
    again_ms = 300

    def __init__(self, write, tell, board):
        AnyMachine.__init__(self, tell, NoJob(), board)
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
        words = ["place", "jog", "step", "goto", "jog_speed", "unlock", "log", "origin"]
        if board["weaving"]:
            words.append("weave")
        if [output for output in board["outputs"] if output["role"] == "ours"]:
            words.append("motors")
        self.can = tuple(words)

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
        if self.jog.active and since(self._now_ms, self._repeated_ms) >= _REPEAT_MS:
            self._repeated_ms = self._now_ms
            self._write(torch.frame(self._way))

    def _report(self, fields):
        state = self.state
        before = self._steps
        passed = since(self._now_ms, self._heard_ms)
        self._reported()
        name = fields["state"]
        state["state"] = name[:1].upper() + name[1:]
        self._steps = [fields["x"], fields["y"]]
        self.place = state["m"] = state["w"] = [round(self._steps[axis] / self.scale[axis], 4) for axis in range(2)]
        if before and 0 < passed:
            far = sum([((self._steps[axis] - before[axis]) / self.scale[axis]) ** 2 for axis in range(2)]) ** 0.5
            state["feed"] = round(far * 60_000 / passed)
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

    def _moved(self, steps, speed):
        """Go so many steps, straight, at `speed` mm/min."""
        if self.still() or self._steps is None:
            return errors.BUSY
        way = [steps[axis] / self.scale[axis] for axis in range(2)]
        length = sum([part * part for part in way]) ** 0.5
        if not length:
            return 0
        speeds = [max(1, round(abs(steps[axis]) * speed / 60 / length)) for axis in range(2)]
        return self._independently(steps, speeds)

    def _independently(self, steps, speeds):
        signed = [speeds[axis] if steps[axis] >= 0 else -speeds[axis] for axis in range(2)]
        return self._order(torch.move(abs(steps[0]), signed[0], abs(steps[1]), signed[1]))

    def step(self, way, speed):
        """{axis: mm} from here."""
        return self._moved([round(way.get(axis, 0) * self.scale["xy".index(axis)]) for axis in "xy"], speed)

    def go(self, place, speed):
        """{axis: mm}, straight."""
        if self._steps is None:
            return errors.BUSY
        wanted = [round(place[axis] * self.scale["xy".index(axis)]) if axis in place else self._steps["xy".index(axis)] for axis in "xy"]
        return self._moved([wanted[axis] - self._steps[axis] for axis in range(2)], speed)

    def _speed_of(self, order, name, axis):
        """Steps/s of a field in mm/min."""
        return max(1, round(number(order, name, 0.1, 50_000) * self.scale[axis] / 60))

    def _move(self, order):
        """Each axis goes its own way at its own speed: by {axis: mm}, xv and yv in mm/min."""
        way = places(order, "by", "xy")
        speeds = [self._speed_of(order, name, axis) for axis, name in enumerate(("xv", "yv"))]
        steps = [round(way.get(axis, 0) * self.scale["xy".index(axis)]) for axis in "xy"]
        return self.refusal() or self.still() or self._independently(steps, speeds)

    def _configure(self, order):
        """mm of a jog and default speeds in mm/min, of both axes."""
        jogs = [round(number(order, name, 0.001, _MOST_JOG_MM) * self.scale[axis]) for axis, name in enumerate(("jogx", "jogy"))]
        speeds = [self._speed_of(order, name, axis) for axis, name in enumerate(("xv", "yv"))]
        if [jog for jog in jogs if not jog]:
            raise Wrong("jogx")
        error = self.refusal() or self.still() or self._order(torch.configure(jogs[0], jogs[1], speeds[0], speeds[1]))
        if not error:
            self._jogs, self._speeds = jogs, speeds
        return error

    def _told(self, order):
        """The preferences as this page knows them: mm and mm/min."""
        return {
            "t": "preferences", "do": "preferences", "error": 0, "scale": self.scale[:2],
            "jog": [round(self._jogs[axis] / self.scale[axis], 3) for axis in range(2)],
            "speed": [round(self._speeds[axis] * 60 / self.scale[axis], 1) for axis in range(2)],
        }  # fmt: skip

    def _origin(self, order):
        return self.refusal() or self.still() or self._order(torch.frame("ORIGIN"))

    def _weave(self, order):
        """A seam to (x, y) mm from here; `centre`: it is an arc about that place, also from here."""
        if text(order, "shape", 12) not in _SHAPES:
            raise Wrong("shape")
        to = places(order, "to", "xy")
        centre = places(order, "centre", "xy") if "centre" in order else {}
        spec = (
            _SHAPES.index(order["shape"]) + 1, round(number(order, "amplitude", 0.001, 100) * 1000), round(number(order, "pitch", 0.1, 1000) * 1000),
            int(number(order, "left", 0, 60_000, 0)), int(number(order, "right", 0, 60_000, 0)), 1 if order.get("along") else 0,
        )  # fmt: skip
        speed = max(1, min(_MOST_UM_S, round(number(order, "speed", 0.1, 50_000) * 1000 / 60)))
        x, y = [round(to.get(axis, 0) * self.scale["xy".index(axis)]) for axis in "xy"]
        around = [round(centre.get(axis, 0) * self.scale["xy".index(axis)]) for axis in "xy"]
        return self.refusal() or self.still() or self._order(torch.weave(spec, x, y, speed, around, bool(order.get("clockwise"))))

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
